#include "shim.h"

#include "IpoptConfig.h"

#include "IpBlas.hpp"
#include "IpCompoundVector.hpp"
#include "IpDenseVector.hpp"
#include "IpExpansionMatrix.hpp"
#include "IpIpoptApplication.hpp"
#include "IpIpoptCalculatedQuantities.hpp"
#include "IpIpoptData.hpp"
#include "IpJournalist.hpp"
#include "IpOptionsList.hpp"
#include "IpOrigIpoptNLP.hpp"
#include "IpRegOptions.hpp"
#include "IpSolveStatistics.hpp"
#include "IpTNLP.hpp"
#include "IpTNLPAdapter.hpp"
#include "IpTimingStatistics.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <iterator>
#include <limits>
#include <new>
#include <sstream>
#include <string>
#include <type_traits>
#include <vector>

#include <dlfcn.h>
#if defined(__GLIBC__)
#include <malloc.h>
#if __GLIBC_PREREQ(2, 33)
#define SHIM_MALLINFO2 1
#endif
#endif

using namespace Ipopt;

static_assert(sizeof(Index) == 4, "ipopt-sys supports Ipopt with 32-bit indices only");
static_assert(std::is_same<Number, double>::value, "ipopt-sys supports Ipopt in double precision only");

#if IPOPT_VERSION_MAJOR > 3 || (IPOPT_VERSION_MAJOR == 3 && IPOPT_VERSION_MINOR >= 14)
#define SHIM_IPOPT_3_14 1
#else
#define SHIM_IPOPT_3_14 0
#endif

#if SHIM_IPOPT_3_14
#include "IpLinearSolvers.h"
#endif

#if IPOPT_VERSION_MAJOR > 3 ||                                                                                         \
    (IPOPT_VERSION_MAJOR == 3 &&                                                                                       \
     (IPOPT_VERSION_MINOR > 14 || (IPOPT_VERSION_MINOR == 14 && IPOPT_VERSION_RELEASE >= 18)))
// Of Ipopt's C interface, whose header does not go together with the C++ ones in all versions.
extern "C" void GetIpoptVersion(int *major, int *minor, int *release);
#define SHIM_IPOPT_TELLS_VERSION 1
#else
#define SHIM_IPOPT_TELLS_VERSION 0
#endif

namespace {

/** Where an iterate is read from; set while Ipopt is in the intermediate callback. */
struct Current {
    bool restoration = false;
    const IpoptData *data = nullptr;
    IpoptCalculatedQuantities *cq = nullptr;

    bool set() const { return data != nullptr; }
};

} // namespace

struct ipopt_shim {
    SmartPtr<IpoptApplication> options;  // owns the registered options and their values
    SmartPtr<IpoptApplication> running;  // the application of the solve under way
    Current current;

    int n = 0, m = 0;
    std::vector<int> jacobian_rows, jacobian_cols, hessian_rows, hessian_cols;
    std::vector<double> x_lower, x_upper, g_lower, g_upper;
    double objective_scaling = 1.0;
    std::vector<double> x_scaling, g_scaling;
};

namespace {

/** Ipopt's log, as text, to a callback. */
class LogJournal : public Journal {
public:
    typedef void (*Sink)(void *user, const char *text, size_t length);

    LogJournal(const char *name, EJournalLevel level, Sink sink, void *user)
        : Journal(name, level), sink_(sink), user_(user) {}

protected:
    void PrintImpl(EJournalCategory, EJournalLevel, const char *text) override {
        sink_(user_, text, std::strlen(text));
    }
    void PrintfImpl(EJournalCategory, EJournalLevel, const char *format, va_list arguments) override {
        char text[1024];
        va_list again;
        va_copy(again, arguments);
        const int length = std::vsnprintf(text, sizeof text, format, arguments);
        if (length >= static_cast<int>(sizeof text)) {
            std::vector<char> longer(static_cast<size_t>(length) + 1);
            std::vsnprintf(longer.data(), longer.size(), format, again);
            sink_(user_, longer.data(), static_cast<size_t>(length));
        } else if (length > 0) {
            sink_(user_, text, static_cast<size_t>(length));
        }
        va_end(again);
    }
    void FlushBufferImpl() override {}

private:
    const Sink sink_;
    void *const user_;
};

/** Bytes this process has allocated at present, -1 where nobody says. */
long long allocated_bytes() {
#ifdef SHIM_MALLINFO2
    const struct mallinfo2 info = mallinfo2();
    return static_cast<long long>(info.uordblks + info.hblkhd);
#else
    return -1;
#endif
}

/** Thrown between the calls of MUMPS to end a solve. */
struct Ended {};

/** Counts and times the calls of MUMPS, and ends the solve between them. Ipopt keeps no such count, and does not time MUMPS' factorisations, but it
 *  announces each call and its end. Formats are compared with known ones and nothing is formatted, so that a message
 *  costs less than a microsecond. */
class MumpsJournal : public Journal {
public:
    explicit MumpsJournal(const ipopt_shim_callbacks &callbacks) : Journal("ipopt_shim_mumps", J_NONE), callbacks_(callbacks) {
        SetPrintLevel(J_LINEAR_ALGEBRA, J_MOREDETAILED);
    }

    /** Ipopt shows an iterate. */
    void iterated() { since_iterate_ = 0; }

    /** How the solve was ended between two calls, Solve_Succeeded if it was not. */
    int ended() const { return ended_; }

    void read(ipopt_shim_statistics &out) const {
        out.factorizations = jobs_[1].calls;
        out.back_solves = jobs_[2].calls;
        out.symbolic_factorization = jobs_[0].time;
        out.factorization = jobs_[1].time;
        out.back_solve = jobs_[2].time;
        out.timing_available = 1;
        out.factor_reals = factor_reals_;
        out.factor_integers = factor_integers_;
        out.pivot_order = pivot_order_;
        out.reallocations = reallocations_;
        out.workspace_bytes = workspace_bytes_;
    }

protected:
    void PrintImpl(EJournalCategory category, EJournalLevel, const char *text) override {
        if (category == J_LINEAR_ALGEBRA) {
            announced(text);
        }
    }
    void PrintfImpl(EJournalCategory category, EJournalLevel, const char *format, va_list arguments) override {
        if (category != J_LINEAR_ALGEBRA) {
            return;
        }
        va_list again;
        va_copy(again, arguments);
        if (starts_with(format, "Number of doubles for MUMPS to hold factorization")) {
            factor_reals_ = count(va_arg(again, int));
        } else if (starts_with(format, "Number of integers for MUMPS to hold factorization")) {
            factor_integers_ = count(va_arg(again, int));
        } else if (starts_with(format, "MUMPS used permuting_scaling")) {
            (void)va_arg(again, int);
            pivot_order_ = va_arg(again, int);
        } else if (starts_with(format, "MUMPS returned INFO(1) = %d and requires more memory")) {
            ++reallocations_;
        } else if (is_failure(format) && is_of_memory(va_arg(again, int))) {
            va_end(again);
            end(Insufficient_Memory);
        }
        va_end(again);
        announced(format);
    }
    void FlushBufferImpl() override {}

private:
    typedef std::chrono::steady_clock Clock;

    /** 1 analyses, 2 factorises, 3 solves. */
    struct Job {
        long long calls = 0;
        ipopt_shim_time time = {0.0, 0.0};
    };

    template <size_t Size> static bool starts_with(const char *text, const char (&prefix)[Size]) {
        return std::strncmp(text, prefix, Size - 1) == 0;
    }

    /** Whether a message begins with what MUMPS returned as it failed. */
    static bool is_failure(const char *format) {
        return starts_with(format, "MUMPS returned INFO(1) =%d") || starts_with(format, "Error=%d returned from MUMPS");
    }

    /** Whether MUMPS failed for want of memory: in its analysis, in general, or by its own limit. Ipopt would go on, to a
     *  restoration phase that fails likewise. */
    static bool is_of_memory(int info) {
        return info == -5 || info == -7 || info == -13 || info == -19 || info == -20 || info == -22;
    }

    /** MUMPS counts what is large in millions, and says so by the sign. */
    static long long count(int number) { return number >= 0 ? number : -1000000LL * number; }

    Job *job_named(char number) { return number >= '1' && number <= '3' ? &jobs_[number - '1'] : nullptr; }

    void announced(const char *text) {
        static const char calling[] = "Calling MUMPS-", done[] = "Done with MUMPS-";
        if (starts_with(text, calling)) {
            if (Job *job = job_named(text[sizeof calling - 1])) {
                if (job == &jobs_[1] && ++since_iterate_ > MOST) {
                    end(Error_In_Step_Computation);
                } else if (callbacks_.stops != nullptr && callbacks_.stops(callbacks_.user, job == &jobs_[1]) != 0) {
                    end(User_Requested_Stop);
                }
                ++job->calls;
                if (is_first_factorization(job)) {
                    allocated_before_ = allocated_bytes();
                }
                cpu_ = std::clock();
                wall_ = Clock::now();
            }
        } else if (starts_with(text, done)) {
            if (Job *job = job_named(text[sizeof done - 1])) {
                job->time.cpu += static_cast<double>(std::clock() - cpu_) / CLOCKS_PER_SEC;
                job->time.wall += std::chrono::duration<double>(Clock::now() - wall_).count();
                if (is_first_factorization(job) && allocated_before_ >= 0) {
                    workspace_bytes_ = std::max(allocated_bytes() - allocated_before_, 0LL);
                }
            }
        }
    }

    /** Factorisations between two iterates. Ipopt needs a hundred at most, unless its regularisation has no effect: then
     *  it would go on for ever. */
    static const int MOST = 1000;

    void end(int status) {
        ended_ = status;
        throw Ended();
    }

    bool is_first_factorization(const Job *job) const { return job == &jobs_[1] && job->calls == 1; }

    Job jobs_[3];
    long long factor_reals_ = -1, factor_integers_ = -1, workspace_bytes_ = -1, allocated_before_ = -1;
    int pivot_order_ = -1, reallocations_ = 0, since_iterate_ = 0, ended_ = Solve_Succeeded;
    const ipopt_shim_callbacks &callbacks_;
    std::clock_t cpu_ = 0;
    Clock::time_point wall_;
};

/** The version that Ipopt announces in its log, in the format itself: that of the library, not of the headers. */
class VersionJournal : public Journal {
public:
    VersionJournal() : Journal("ipopt_shim_version", J_NONE) { SetPrintLevel(J_MAIN, J_ITERSUMMARY); }

    /** Of the first that was told; 0.0.0 before. A process has but one Ipopt. */
    static std::atomic<int> told[3];

protected:
    void PrintImpl(EJournalCategory, EJournalLevel, const char *text) override { announced(text); }
    void PrintfImpl(EJournalCategory, EJournalLevel, const char *format, va_list) override { announced(format); }
    void FlushBufferImpl() override {}

private:
    static void announced(const char *text) {
        int numbers[3];
        if (told[0] == 0 && std::strncmp(text, "This is Ipopt", 13) == 0 &&
            std::sscanf(text, "This is Ipopt version %d.%d.%d", &numbers[0], &numbers[1], &numbers[2]) == 3) {
            for (int i = 2; i >= 0; --i) {
                told[i] = numbers[i];
            }
        }
    }
};

std::atomic<int> VersionJournal::told[3];

class Problem : public TNLP {
public:
    Problem(ipopt_shim &shim, const ipopt_shim_callbacks &callbacks, ipopt_shim_point &point,
            const SmartPtr<MumpsJournal> &mumps)
        : shim_(shim), callbacks_(callbacks), point_(point), mumps_(mumps) {}

    bool get_nlp_info(Index &n, Index &m, Index &jacobian, Index &hessian, IndexStyleEnum &style) override {
        n = shim_.n;
        m = shim_.m;
        jacobian = static_cast<Index>(shim_.jacobian_rows.size());
        hessian = static_cast<Index>(shim_.hessian_rows.size());
        style = C_STYLE;
        return true;
    }

    bool get_bounds_info(Index, Number *x_l, Number *x_u, Index, Number *g_l, Number *g_u) override {
        std::copy(shim_.x_lower.begin(), shim_.x_lower.end(), x_l);
        std::copy(shim_.x_upper.begin(), shim_.x_upper.end(), x_u);
        std::copy(shim_.g_lower.begin(), shim_.g_lower.end(), g_l);
        std::copy(shim_.g_upper.begin(), shim_.g_upper.end(), g_u);
        return true;
    }

    bool get_scaling_parameters(Number &objective, bool &use_x, Index, Number *x, bool &use_g, Index,
                                Number *g) override {
        objective = shim_.objective_scaling;
        use_x = !shim_.x_scaling.empty();
        use_g = !shim_.g_scaling.empty();
        std::copy(shim_.x_scaling.begin(), shim_.x_scaling.end(), x);
        std::copy(shim_.g_scaling.begin(), shim_.g_scaling.end(), g);
        return true;
    }

    bool get_starting_point(Index n, bool init_x, Number *x, bool init_z, Number *z_L, Number *z_U, Index m,
                            bool init_lambda, Number *lambda) override {
        if ((init_z || init_lambda) && !point_.have_multipliers) {
            return false;
        }
        if (init_x) {
            std::copy(point_.x, point_.x + n, x);
        }
        if (init_z) {
            std::copy(point_.z_lower, point_.z_lower + n, z_L);
            std::copy(point_.z_upper, point_.z_upper + n, z_U);
        }
        if (init_lambda) {
            std::copy(point_.lambda, point_.lambda + m, lambda);
        }
        return true;
    }

    bool eval_f(Index, const Number *x, bool new_x, Number &value) override {
        return callbacks_.objective(callbacks_.user, x, new_x, &value) != 0;
    }

    bool eval_grad_f(Index, const Number *x, bool new_x, Number *gradient) override {
        return callbacks_.gradient(callbacks_.user, x, new_x, gradient) != 0;
    }

    bool eval_g(Index, const Number *x, bool new_x, Index m, Number *g) override {
        return m == 0 || callbacks_.constraints(callbacks_.user, x, new_x, g) != 0;
    }

    bool eval_jac_g(Index, const Number *x, bool new_x, Index, Index entries, Index *rows, Index *cols,
                    Number *values) override {
        if (values == nullptr) {
            std::copy(shim_.jacobian_rows.begin(), shim_.jacobian_rows.end(), rows);
            std::copy(shim_.jacobian_cols.begin(), shim_.jacobian_cols.end(), cols);
            return true;
        }
        return entries == 0 || callbacks_.jacobian(callbacks_.user, x, new_x, values) != 0;
    }

    bool eval_h(Index, const Number *x, bool new_x, Number objective_factor, Index, const Number *lambda,
                bool new_lambda, Index entries, Index *rows, Index *cols, Number *values) override {
        if (values == nullptr) {
            std::copy(shim_.hessian_rows.begin(), shim_.hessian_rows.end(), rows);
            std::copy(shim_.hessian_cols.begin(), shim_.hessian_cols.end(), cols);
            return true;
        }
        return entries == 0 || callbacks_.hessian(callbacks_.user, x, new_x, objective_factor, lambda, new_lambda,
                                                  values) != 0;
    }

    void finalize_solution(SolverReturn status, Index n, const Number *x, const Number *z_L, const Number *z_U, Index m,
                           const Number *g, const Number *lambda, Number objective, const IpoptData *,
                           IpoptCalculatedQuantities *) override {
        std::copy(x, x + n, point_.x);
        std::copy(z_L, z_L + n, point_.z_lower);
        std::copy(z_U, z_U + n, point_.z_upper);
        std::copy(lambda, lambda + m, point_.lambda);
        if (has_values(status)) {
            std::copy(g, g + m, point_.g);
            point_.objective = objective;
        }
        point_.finalized = 1;
    }

    bool intermediate_callback(AlgorithmMode mode, Index iteration, Number objective, Number inf_pr, Number inf_du,
                               Number mu, Number d_norm, Number regularization, Number alpha_du, Number alpha_pr,
                               Index trials, const IpoptData *data, IpoptCalculatedQuantities *cq) override {
        const ipopt_shim_iteration record = {mode == RestorationPhaseMode, iteration, objective, inf_pr,
                                             inf_du,   mu,       d_norm, regularization,
                                             alpha_du, alpha_pr, trials};
        if (IsValid(mumps_)) {
            mumps_->iterated();
        }
        shim_.current.restoration = mode == RestorationPhaseMode;
        shim_.current.data = data;
        shim_.current.cq = cq;
        const bool go_on = callbacks_.intermediate(callbacks_.user, &record) != 0;
        shim_.current = Current();
        return go_on;
    }

private:
    /** Whether Ipopt ends with f(x) and g(x). After a time limit, an invalid number or an exception it has zeros in
     *  their place. */
    static bool has_values(SolverReturn status) {
        switch (status) {
        case SUCCESS:
        case MAXITER_EXCEEDED:
        case STOP_AT_TINY_STEP:
        case STOP_AT_ACCEPTABLE_POINT:
        case LOCAL_INFEASIBILITY:
        case USER_REQUESTED_STOP:
        case FEASIBLE_POINT_FOUND:
        case DIVERGING_ITERATES:
        case RESTORATION_FAILURE:
        case ERROR_IN_STEP_COMPUTATION:
            return true;
        default:
            return false;
        }
    }

    ipopt_shim &shim_;
    const ipopt_shim_callbacks &callbacks_;
    ipopt_shim_point &point_;
    const SmartPtr<MumpsJournal> mumps_;
};

/** Ipopt's view of the problem under way: its scaling, and its map from and to the caller's numbering.
 *  Both are null outside a solve and where Ipopt put another layer between. */
struct View {
    SmartPtr<OrigIpoptNLP> nlp;
    SmartPtr<TNLPAdapter> adapter;

    explicit View(const ipopt_shim &shim) {
        if (IsValid(shim.running) && shim.current.set()) {
            nlp = dynamic_cast<OrigIpoptNLP *>(GetRawPtr(shim.running->IpoptNLPObject()));
            if (IsValid(nlp)) {
                adapter = dynamic_cast<TNLPAdapter *>(GetRawPtr(nlp->nlp()));
            }
        }
    }
    bool valid() const { return IsValid(nlp) && IsValid(adapter); }
};

/** The same multipliers for the unscaled problem. */
SmartPtr<const Vector> unscaled(const SmartPtr<Vector> &scaled, Number factor) {
    if (factor != 1.0) {
        scaled->Scal(factor);
    }
    return ConstPtr(scaled);
}

/** Distances from bounds, which Ipopt keeps for those that there are, in the vector `all` of what they bound; infinity
 *  where there is none. Null if Ipopt keeps them in another form. */
SmartPtr<const Vector> spread(const SmartPtr<const Matrix> &places, const SmartPtr<const Vector> &distances,
                              const Vector &all) {
    const ExpansionMatrix *expansion = dynamic_cast<const ExpansionMatrix *>(GetRawPtr(places));
    const DenseVector *dense = dynamic_cast<const DenseVector *>(GetRawPtr(distances));
    SmartPtr<Vector> out = all.MakeNew();
    DenseVector *written = dynamic_cast<DenseVector *>(GetRawPtr(out));
    if (expansion == nullptr || dense == nullptr || written == nullptr) {
        return nullptr;
    }
    out->Set(std::numeric_limits<Number>::infinity());
    if (dense->Dim() > 0) {
        const Number *values = dense->ExpandedValues();
        const Index *positions = expansion->ExpandedPosIndices();
        Number *to = written->Values();
        for (Index i = 0; i < dense->Dim(); ++i) {
            to[positions[i]] = values[i];
        }
    }
    return ConstPtr(out);
}

/** What belongs to the variables, which is unscaled already, in the caller's places; 0 for fixed variables that are
 *  none to Ipopt. */
void resort_x(const ipopt_shim &shim, TNLPAdapter &adapter, const Vector &values, double *out) {
    adapter.ResortX(values, out);
    for (size_t i = 0; values.Dim() < shim.n && i < shim.x_lower.size(); ++i) {
        if (shim.x_lower[i] == shim.x_upper[i]) {
            out[i] = 0.0;
        }
    }
}

/** What belongs to the inequalities, which is unscaled already, in the caller's places; 0 for equalities. */
void resort_d(TNLPAdapter &adapter, const Vector &equalities, const Vector &values, double *out) {
    const SmartPtr<Vector> zero = equalities.MakeNew();
    zero->Set(0.0);
    adapter.ResortG(*zero, values, out);
}

std::string range_of(const RegisteredOption &option) {
    std::ostringstream text;
    if (option.Type() == OT_String) {
        text << "one of";
        const auto settings = option.GetValidStrings();
        for (const auto &setting : settings) {
            if (setting.value_ == "*") {
                return "any text";
            }
            text << " \"" << setting.value_ << '"';
        }
        return text.str();
    }
    const bool integer = option.Type() == OT_Integer;
    text << (integer ? "an integer" : "a number");
    if (option.HasLower()) {
        text << (!integer && option.LowerStrict() ? " > " : " >= ");
        integer ? text << option.LowerInteger() : text << option.LowerNumber();
    }
    if (option.HasUpper()) {
        text << (option.HasLower() ? " and" : "") << (!integer && option.UpperStrict() ? " < " : " <= ");
        integer ? text << option.UpperInteger() : text << option.UpperNumber();
    }
    return text.str();
}

SmartPtr<const RegisteredOption> registered(ipopt_shim &shim, const char *name) {
    return shim.options->RegOptions()->GetOption(name);
}

ipopt_shim_time time_of(const TimedTask &task) { return {task.TotalCpuTime(), task.TotalWallclockTime()}; }

void read_statistics(IpoptApplication &application, ipopt_shim_statistics &out) {
    SmartPtr<SolveStatistics> statistics = application.Statistics();
    if (IsValid(statistics)) {
        out.available = 1;
        out.iterations = statistics->IterationCount();
        statistics->NumberOfEvaluations(out.objective_evaluations, out.constraint_evaluations,
                                        out.gradient_evaluations, out.jacobian_evaluations, out.hessian_evaluations);
        out.cpu_time = statistics->TotalCpuTime();
        out.wall_time = statistics->TotalWallclockTime();
        Number ignored[3];
#if SHIM_IPOPT_3_14
        Number bounds;
        statistics->Infeasibilities(out.dual_infeasibility, out.constraint_violation, bounds, out.complementarity,
                                    out.kkt_error);
        statistics->ScaledInfeasibilities(ignored[0], ignored[1], bounds, ignored[2], out.scaled_kkt_error);
#else
        statistics->Infeasibilities(out.dual_infeasibility, out.constraint_violation, out.complementarity,
                                    out.kkt_error);
        statistics->ScaledInfeasibilities(ignored[0], ignored[1], ignored[2], out.scaled_kkt_error);
#endif
    }
    SmartPtr<IpoptData> data = application.IpoptDataObject();
    if (IsValid(data)) {
        TimingStatistics &timing = data->TimingStats();
        out.timing_available = 1;
        out.symbolic_factorization = time_of(timing.LinearSystemSymbolicFactorization());
        out.factorization = time_of(timing.LinearSystemFactorization());
        out.back_solve = time_of(timing.LinearSystemBackSolve());
    }
}

std::string word(const ipopt_shim &shim, const char *option) {
    std::string value;
    shim.options->Options()->GetStringValue(option, value, "");
    return value;
}

#if SHIM_IPOPT_3_14
/** Whether the library HSL, from which Ipopt takes what it was not linked with, lacks a function. It is opened as Ipopt
 *  does, and stays open. */
bool misses_in_hsl(const ipopt_shim &shim, const char *function) {
    const std::string library = word(shim, "hsllib");
    void *hsl = library.empty() ? nullptr : dlopen(library.c_str(), RTLD_NOW);
    return hsl == nullptr || dlsym(hsl, function) == nullptr;
}

/** MA97 does not fail as others do where it is missing: its end crashes. */
bool would_end_the_process(const ipopt_shim &shim) {
    return word(shim, "linear_solver") == "ma97" &&
           (IpoptGetAvailableLinearSolvers(1) & IPOPTLINEARSOLVER_MA97) == 0 &&
           misses_in_hsl(shim, "ma97_default_control_d");
}
#else
/** Whether HSL lacks a function that Ipopt ends the process without. Ipopt loads HSL when it is needed. */
bool misses_in_hsl(const char *function) {
    if (dlsym(RTLD_DEFAULT, "LSL_loadHSL") == nullptr) {
        return false;
    }
#ifdef __APPLE__
    void *hsl = dlopen("libhsl.dylib", RTLD_LAZY);
#else
    void *hsl = dlopen("libhsl.so", RTLD_LAZY);
#endif
    return hsl == nullptr || dlsym(hsl, function) == nullptr;
}

/** Two options need HSL and do not fail as others do where it is missing: MA97, and MC19 for the scaling. */
bool would_end_the_process(const ipopt_shim &shim) {
    return (word(shim, "linear_solver") == "ma97" && misses_in_hsl("ma97_default_control_d")) ||
           (word(shim, "nlp_scaling_method") == "equilibration-based" && misses_in_hsl("mc19ad_"));
}
#endif

/** As Ipopt was built, it hands on what the journal throws, or takes it for an exception of its own. */
int optimize_to_the_end(IpoptApplication &application, const SmartPtr<TNLP> &problem) {
    try {
        return application.OptimizeTNLP(problem);
    } catch (const Ended &) {
        return NonIpopt_Exception_Thrown;
    }
}

int optimize(ipopt_shim &shim, const ipopt_shim_callbacks &callbacks, ipopt_shim_point &point,
             ipopt_shim_statistics &statistics) {
    SmartPtr<Journalist> journalist = shim.options->Jnlst();
    journalist->DeleteAllJournals();
    if (callbacks.log != nullptr) {
        Index level = 0;
        shim.options->Options()->GetIntegerValue("print_level", level, "");
        journalist->AddJournal(new LogJournal("ipopt_shim_log", static_cast<EJournalLevel>(level), callbacks.log,
                                              callbacks.user));
    }
    if (callbacks.derivative_check != nullptr) {
        SmartPtr<Journal> checker = new LogJournal("ipopt_shim_derivative_check", J_NONE, callbacks.derivative_check,
                                                   callbacks.user);
        checker->SetPrintLevel(J_NLP, J_WARNING);
        journalist->AddJournal(checker);
    }
    journalist->AddJournal(new VersionJournal());
    if (would_end_the_process(shim)) {
        return Invalid_Option;
    }
    SmartPtr<MumpsJournal> mumps;
    if (word(shim, "linear_solver") == "mumps") {
        mumps = new MumpsJournal(callbacks);
        journalist->AddJournal(GetRawPtr(mumps));
    }

    // A clone shares options and journals, and takes the linear solver's memory with it when it goes.
    shim.running = shim.options->clone();
    int status = shim.running->Initialize();
    if (status == Solve_Succeeded) {
        SmartPtr<TNLP> problem = new Problem(shim, callbacks, point, mumps);
        status = optimize_to_the_end(*shim.running, problem);
        read_statistics(*shim.running, statistics);
    }
    if (IsValid(mumps)) {
        mumps->read(statistics);
        if (mumps->ended() != Solve_Succeeded) {
            status = mumps->ended();
        }
    }
    return status;
}

/** What a function returns when C++ threw. */
template <typename Result, typename Body> Result guarded(Result otherwise, Body body) noexcept {
    try {
        return body();
    } catch (...) {
        return otherwise;
    }
}

} // namespace

extern "C" {

ipopt_shim *ipopt_shim_create(int n, int m, int jacobian_entries, const int *jacobian_rows, const int *jacobian_cols,
                              int hessian_entries, const int *hessian_rows, const int *hessian_cols) {
    ipopt_shim *shim = nullptr;
    try {
        shim = new ipopt_shim();
        shim->options = new IpoptApplication(false);
        if (ipopt_shim_set_structure(shim, n, m, jacobian_entries, jacobian_rows, jacobian_cols, hessian_entries,
                                     hessian_rows, hessian_cols) != 0) {
            return shim;
        }
    } catch (...) {
    }
    delete shim;
    return nullptr;
}

int ipopt_shim_set_structure(ipopt_shim *shim, int n, int m, int jacobian_entries, const int *jacobian_rows,
                             const int *jacobian_cols, int hessian_entries, const int *hessian_rows,
                             const int *hessian_cols) {
    return guarded(0, [&] {
        shim->n = n;
        shim->m = m;
        shim->jacobian_rows.assign(jacobian_rows, jacobian_rows + jacobian_entries);
        shim->jacobian_cols.assign(jacobian_cols, jacobian_cols + jacobian_entries);
        shim->hessian_rows.assign(hessian_rows, hessian_rows + hessian_entries);
        shim->hessian_cols.assign(hessian_cols, hessian_cols + hessian_entries);
        shim->x_lower.assign(static_cast<size_t>(n), -1e300);
        shim->x_upper.assign(static_cast<size_t>(n), 1e300);
        shim->g_lower.assign(static_cast<size_t>(m), -1e300);
        shim->g_upper.assign(static_cast<size_t>(m), 1e300);
        return ipopt_shim_set_scaling(shim, 1.0, nullptr, nullptr);
    });
}

void ipopt_shim_free(ipopt_shim *shim) {
    try {
        delete shim;
    } catch (...) {
    }
}

void ipopt_shim_set_bounds(ipopt_shim *shim, const double *x_lower, const double *x_upper, const double *g_lower,
                           const double *g_upper) {
    std::copy(x_lower, x_lower + shim->n, shim->x_lower.begin());
    std::copy(x_upper, x_upper + shim->n, shim->x_upper.begin());
    std::copy(g_lower, g_lower + shim->m, shim->g_lower.begin());
    std::copy(g_upper, g_upper + shim->m, shim->g_upper.begin());
}

int ipopt_shim_set_scaling(ipopt_shim *shim, double objective, const double *x, const double *g) {
    return guarded(0, [&] {
        shim->objective_scaling = objective;
        shim->x_scaling.assign(x, x + (x != nullptr ? shim->n : 0));
        shim->g_scaling.assign(g, g + (g != nullptr ? shim->m : 0));
        return 1;
    });
}

int ipopt_shim_option_type(ipopt_shim *shim, const char *name) {
    return guarded(IPOPT_SHIM_OPTION_UNKNOWN, [&] {
        const auto option = registered(*shim, name);
        if (IsValid(option)) {
            switch (option->Type()) {
            case OT_Number:
                return IPOPT_SHIM_OPTION_NUMBER;
            case OT_Integer:
                return IPOPT_SHIM_OPTION_INTEGER;
            case OT_String:
                return IPOPT_SHIM_OPTION_TEXT;
            default:
                break;
            }
        }
        return IPOPT_SHIM_OPTION_UNKNOWN;
    });
}

void ipopt_shim_option_range(ipopt_shim *shim, const char *name, char *text, size_t size) {
    guarded(0, [&] {
        const auto option = registered(*shim, name);
        std::snprintf(text, size, "%s", IsValid(option) ? range_of(*option).c_str() : "");
        return 1;
    });
}

int ipopt_shim_option_default(ipopt_shim *shim, const char *name, double *number, char *text, size_t size) {
    return guarded(IPOPT_SHIM_OPTION_UNKNOWN, [&] {
        const int type = ipopt_shim_option_type(shim, name);
        const auto option = registered(*shim, name);
        if (type == IPOPT_SHIM_OPTION_NUMBER) {
            *number = option->DefaultNumber();
        } else if (type == IPOPT_SHIM_OPTION_INTEGER) {
            *number = option->DefaultInteger();
        } else if (type == IPOPT_SHIM_OPTION_TEXT) {
            std::snprintf(text, size, "%s", option->DefaultString().c_str());
        }
        return type;
    });
}

int ipopt_shim_option_name(ipopt_shim *shim, size_t place, char *name, size_t size) {
    return guarded(0, [&] {
        const auto &options = shim->options->RegOptions()->RegisteredOptionsList();
        if (place >= options.size()) {
            return 0;
        }
        auto option = options.begin();
        std::advance(option, static_cast<std::ptrdiff_t>(place));
        std::snprintf(name, size, "%s", option->first.c_str());
        return 1;
    });
}

void ipopt_shim_clear_options(ipopt_shim *shim) {
    guarded(0, [&] {
        shim->options->Options()->clear();
        return 1;
    });
}

int ipopt_shim_set_text(ipopt_shim *shim, const char *name, const char *value) {
    return guarded(0, [&]() -> int {
        const auto option = registered(*shim, name);
        return IsValid(option) && option->Type() == OT_String && option->IsValidStringSetting(value) &&
               shim->options->Options()->SetStringValue(name, value);
    });
}

int ipopt_shim_set_number(ipopt_shim *shim, const char *name, double value) {
    return guarded(0, [&]() -> int {
        const auto option = registered(*shim, name);
        return IsValid(option) && option->Type() == OT_Number && option->IsValidNumberSetting(value) &&
               shim->options->Options()->SetNumericValue(name, value);
    });
}

int ipopt_shim_set_integer(ipopt_shim *shim, const char *name, int value) {
    return guarded(0, [&]() -> int {
        const auto option = registered(*shim, name);
        return IsValid(option) && option->Type() == OT_Integer && option->IsValidIntegerSetting(value) &&
               shim->options->Options()->SetIntegerValue(name, value);
    });
}

int ipopt_shim_solve(ipopt_shim *shim, const ipopt_shim_callbacks *callbacks, ipopt_shim_point *point,
                     ipopt_shim_statistics *statistics) {
    *statistics = ipopt_shim_statistics();
    statistics->factorizations = statistics->back_solves = -1;
    statistics->factor_reals = statistics->factor_integers = statistics->workspace_bytes = -1;
    statistics->pivot_order = statistics->reallocations = -1;
    point->finalized = 0;
    int status = NonIpopt_Exception_Thrown;
    try {
        status = optimize(*shim, *callbacks, *point, *statistics);
    } catch (const std::bad_alloc &) {
        status = Insufficient_Memory;
    } catch (...) {
    }
    // Neither may outlive the callbacks.
    shim->current = Current();
    try {
        shim->running = nullptr;
        shim->options->Jnlst()->DeleteAllJournals();
    } catch (...) {
    }
    return status;
}

int ipopt_shim_current_x(const ipopt_shim *shim, double *x) {
    return guarded(0, [&] {
        const View view(*shim);
        if (!view.valid()) {
            return 0;
        }
        SmartPtr<const Vector> iterate = shim->current.data->curr()->x();
        if (shim->current.restoration) {
            // The restoration phase works on (x, n_c, p_c, n_d, p_d).
            const CompoundVector *parts = dynamic_cast<const CompoundVector *>(GetRawPtr(iterate));
            if (parts == nullptr) {
                return 0;
            }
            iterate = parts->GetComp(0);
        }
        view.adapter->ResortX(*view.nlp->NLP_scaling()->unapply_vector_scaling_x(iterate), x);
        return 1;
    });
}

int ipopt_shim_current_g(const ipopt_shim *shim, double *g) {
    return guarded(0, [&] {
        const View view(*shim);
        if (!view.valid() || shim->current.restoration) {
            return 0;
        }
        view.adapter->ResortG(*shim->current.cq->unscaled_curr_c(), *shim->current.cq->unscaled_curr_d(), g);
        for (size_t i = 0; i < shim->g_lower.size(); ++i) {
            // Ipopt sees an equality as g - rhs = 0.
            if (shim->g_lower[i] == shim->g_upper[i]) {
                g[i] += shim->g_lower[i];
            }
        }
        return 1;
    });
}

int ipopt_shim_current_multipliers(const ipopt_shim *shim, double *z_lower, double *z_upper, double *lambda) {
    return guarded(0, [&] {
        const View view(*shim);
        if (!view.valid() || shim->current.restoration) {
            return 0;
        }
        const auto curr = shim->current.data->curr();
        const auto scaling = view.nlp->NLP_scaling();
        const Number factor = scaling->unapply_obj_scaling(1.0);
        const SmartPtr<const VectorSpace> space = curr->x()->OwnerSpace();
        view.adapter->ResortG(*unscaled(scaling->apply_vector_scaling_c_NonConst(curr->y_c()), factor),
                              *unscaled(scaling->apply_vector_scaling_d_NonConst(curr->y_d()), factor), lambda);
        std::fill(z_lower, z_lower + shim->n, 0.0);
        std::fill(z_upper, z_upper + shim->n, 0.0);
        view.adapter->ResortBnds(
            *unscaled(scaling->apply_vector_scaling_x_LU_NonConst(*view.nlp->Px_L(), curr->z_L(), *space), factor),
            z_lower,
            *unscaled(scaling->apply_vector_scaling_x_LU_NonConst(*view.nlp->Px_U(), curr->z_U(), *space), factor),
            z_upper);
        return 1;
    });
}

int ipopt_shim_current_slacks(const ipopt_shim *shim, double *x_lower, double *x_upper, double *s, double *s_lower,
                              double *s_upper) {
    return guarded(0, [&] {
        const View view(*shim);
        if (!view.valid() || shim->current.restoration) {
            return 0;
        }
        IpoptCalculatedQuantities &cq = *shim->current.cq;
        const auto curr = shim->current.data->curr();
        const auto scaling = view.nlp->NLP_scaling();
        const auto lower = spread(view.nlp->Px_L(), cq.curr_slack_x_L(), *curr->x());
        const auto upper = spread(view.nlp->Px_U(), cq.curr_slack_x_U(), *curr->x());
        const auto above = spread(view.nlp->Pd_L(), cq.curr_slack_s_L(), *curr->s());
        const auto below = spread(view.nlp->Pd_U(), cq.curr_slack_s_U(), *curr->s());
        if (IsNull(lower) || IsNull(upper) || IsNull(above) || IsNull(below)) {
            return 0;
        }
        resort_x(*shim, *view.adapter, *scaling->unapply_vector_scaling_x(lower), x_lower);
        resort_x(*shim, *view.adapter, *scaling->unapply_vector_scaling_x(upper), x_upper);
        resort_d(*view.adapter, *curr->y_c(), *scaling->unapply_vector_scaling_d(curr->s()), s);
        resort_d(*view.adapter, *curr->y_c(), *scaling->unapply_vector_scaling_d(above), s_lower);
        resort_d(*view.adapter, *curr->y_c(), *scaling->unapply_vector_scaling_d(below), s_upper);
        for (size_t i = 0; i < shim->g_lower.size(); ++i) {
            if (shim->g_lower[i] == shim->g_upper[i]) {
                s[i] = shim->g_lower[i];
            }
        }
        return 1;
    });
}

int ipopt_shim_current_lagrangian(const ipopt_shim *shim, double *gradient, double *objective_factor) {
    return guarded(0, [&] {
        const View view(*shim);
        if (!view.valid() || shim->current.restoration) {
            return 0;
        }
        const auto scaling = view.nlp->NLP_scaling();
        const Number factor = scaling->unapply_obj_scaling(1.0);
        const auto lagrangian = scaling->apply_vector_scaling_x_NonConst(shim->current.cq->curr_grad_lag_x());
        resort_x(*shim, *view.adapter, *unscaled(lagrangian, factor), gradient);
        *objective_factor = 1.0 / factor;
        return 1;
    });
}

int ipopt_shim_library_version(int numbers[3]) {
#if SHIM_IPOPT_TELLS_VERSION
    GetIpoptVersion(&numbers[0], &numbers[1], &numbers[2]);
    return 1;
#else
    for (int i = 0; i < 3; ++i) {
        numbers[i] = VersionJournal::told[i];
    }
    return numbers[0] != 0;
#endif
}

int ipopt_shim_touch_blas(void) {
    return guarded(0, [] {
        // larger than what some BLAS multiply without a buffer
        const Index n = 128;
        const size_t size = static_cast<size_t>(n) * n;
        const std::vector<Number> a(size, 1.0);
        std::vector<Number> product(size, 0.0);
#if SHIM_IPOPT_3_14
        IpBlasGemm(false, false, n, n, n, 1.0, a.data(), n, a.data(), n, 0.0, product.data(), n);
#else
        IpBlasDgemm(false, false, n, n, n, 1.0, a.data(), n, a.data(), n, 0.0, product.data(), n);
#endif
        return static_cast<int>(product.front() == n && product.back() == n);
    });
}

} // extern "C"
