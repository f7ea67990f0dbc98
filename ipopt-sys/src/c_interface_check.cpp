// Compares the C interface in the headers with the bindings kept in the source. It is compiled where those are used,
// and a difference is an error here instead of undefined behaviour there. IPOPT_SYS_BOOL is what `Bool` has to be.

#include "IpStdCInterface.h"

#include <type_traits>

namespace {

template <typename Found, typename Kept> constexpr bool same() { return std::is_same<Found, Kept>::value; }

typedef IPOPT_SYS_BOOL B;
typedef double *D;
typedef void *P;
typedef int *I;
typedef IpoptProblem T;

static_assert(same<Bool, B>() && same<UserDataPtr, P>(), "ipopt-contact-sys: types differ from the bindings kept");
static_assert(same<Eval_F_CB, B (*)(int, D, B, D, P)>() && same<Eval_Grad_F_CB, B (*)(int, D, B, D, P)>() &&
                  same<Eval_G_CB, B (*)(int, D, B, int, D, P)>() &&
                  same<Eval_Jac_G_CB, B (*)(int, D, B, int, int, I, I, D, P)>() &&
                  same<Eval_H_CB, B (*)(int, D, B, double, int, D, B, int, I, I, D, P)>() &&
                  same<Intermediate_CB, B (*)(int, int, double, double, double, double, double, double, double, double,
                                              int, P)>(),
              "ipopt-contact-sys: callbacks differ from the bindings kept");
static_assert(same<decltype(CreateIpoptProblem), T(int, D, D, int, D, D, int, int, int, Eval_F_CB, Eval_G_CB,
                                                   Eval_Grad_F_CB, Eval_Jac_G_CB, Eval_H_CB)>() &&
                  same<decltype(FreeIpoptProblem), void(T)>() &&
                  same<decltype(AddIpoptStrOption), B(T, char *, char *)>() &&
                  same<decltype(AddIpoptNumOption), B(T, char *, double)>() &&
                  same<decltype(AddIpoptIntOption), B(T, char *, int)>() &&
                  same<decltype(OpenIpoptOutputFile), B(T, char *, int)>() &&
                  same<decltype(SetIpoptProblemScaling), B(T, double, D, D)>() &&
                  same<decltype(SetIntermediateCallback), B(T, Intermediate_CB)>() &&
                  same<decltype(IpoptSolve), ApplicationReturnStatus(T, D, D, D, D, D, D, P)>(),
              "ipopt-contact-sys: functions differ from the bindings kept");
static_assert(sizeof(ApplicationReturnStatus) == sizeof(int) && Solve_Succeeded == 0 && Feasible_Point_Found == 6 &&
                  Maximum_CpuTime_Exceeded == -4 && Not_Enough_Degrees_Of_Freedom == -10 &&
                  Invalid_Number_Detected == -13 && Insufficient_Memory == -102 && Internal_Error == -199 &&
                  RegularMode == 0 && RestorationPhaseMode == 1,
              "ipopt-contact-sys: statuses differ from the bindings kept");

} // namespace
