// The problem of overhead.rs through Ipopt's C++ interface.
#include "overhead.h"

#include "IpIpoptApplication.hpp"
#include "IpSolveStatistics.hpp"
#include "IpTNLP.hpp"

#include <algorithm>
#include <vector>

using namespace Ipopt;

class Problem : public TNLP {
public:
    Problem() : value(0.0), c_(N), x(N), z_l(N), z_u(N), g(M), lambda(M) {
        for (int i = 0; i < N; ++i) {
            c_[i] = centre(i);
        }
    }

    bool get_nlp_info(Index &n, Index &m, Index &jac, Index &hess, IndexStyleEnum &style) override {
        n = N;
        m = M;
        jac = N;
        hess = N;
        style = C_STYLE;
        return true;
    }
    bool get_bounds_info(Index, Number *x_l, Number *x_u, Index, Number *g_l, Number *g_u) override {
        std::fill(x_l, x_l + N, 0.0);
        std::fill(x_u, x_u + N, 1.0);
        std::fill(g_l, g_l + M, -1e20);
        std::fill(g_u, g_u + M, LIMIT);
        return true;
    }
    bool get_starting_point(Index, bool, Number *start, bool, Number *, Number *, Index, bool, Number *) override {
        std::fill(start, start + N, START);
        return true;
    }
    bool eval_f(Index, const Number *at, bool, Number &f) override {
        f = objective(c_.data(), at);
        return true;
    }
    bool eval_grad_f(Index, const Number *at, bool, Number *values) override {
        gradient(c_.data(), at, values);
        return true;
    }
    bool eval_g(Index, const Number *at, bool, Index, Number *values) override {
        constraints(at, values);
        return true;
    }
    bool eval_jac_g(Index, const Number *, bool, Index, Index, Index *rows, Index *cols, Number *values) override {
        if (values == nullptr) {
            jacobian_places(rows, cols);
        } else {
            jacobian(values);
        }
        return true;
    }
    bool eval_h(Index, const Number *at, bool, Number factor, Index, const Number *, bool, Index, Index *rows,
                Index *cols, Number *values) override {
        if (values == nullptr) {
            hessian_places(rows, cols);
        } else {
            hessian(at, factor, values);
        }
        return true;
    }
    void finalize_solution(SolverReturn, Index, const Number *x_, const Number *z_l_, const Number *z_u_, Index,
                           const Number *g_, const Number *lambda_, Number f, const IpoptData *,
                           IpoptCalculatedQuantities *) override {
        std::copy(x_, x_ + N, x.begin());
        std::copy(z_l_, z_l_ + N, z_l.begin());
        std::copy(z_u_, z_u_ + N, z_u.begin());
        std::copy(g_, g_ + M, g.begin());
        std::copy(lambda_, lambda_ + M, lambda.begin());
        value = f;
    }

    double value;

private:
    std::vector<double> c_, x, z_l, z_u, g, lambda;
};

int main(int argc, char **argv) {
    Problem *problem = new Problem();
    SmartPtr<TNLP> nlp = problem;
    const double start = cpu_seconds();
    int status, iterations;
    {
        SmartPtr<IpoptApplication> application = new IpoptApplication(false);
        for (int i = 1; i < argc; ++i) {
            char *name, *text;
            const char kind = split(argv[i], &name, &text);
            SmartPtr<OptionsList> options = application->Options();
            const bool set = kind == 'i'   ? options->SetIntegerValue(name, atoi(text))
                             : kind == 'n' ? options->SetNumericValue(name, atof(text))
                                           : options->SetStringValue(name, text);
            if (!set) {
                return 3;
            }
        }
        status = application->Initialize();
        if (status != Solve_Succeeded) {
            return 3;
        }
        status = application->OptimizeTNLP(nlp);
        iterations = application->Statistics()->IterationCount();
    }
    report(cpu_seconds() - start, status, iterations, problem->value);
    return 0;
}
