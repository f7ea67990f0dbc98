//! The options that are one of a few words, as enums.

use super::{OptionValue, known::Setting};

/// A word an option takes, and which builds of Ipopt know it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Word {
    /// As Ipopt writes it.
    pub text: &'static str,
    /// Which builds of Ipopt know it.
    pub available: Available,
}

/// Which builds of Ipopt know a [`Word`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Available {
    /// Every version since 3.11.
    Always,
    /// Those since this version.
    Since(&'static str),
    /// That depends on the version and on what it was built with: this.
    With(&'static str),
}

macro_rules! available {
    () => {
        Available::Always
    };
    (since $version:literal) => {
        Available::Since($version)
    };
    (with $library:literal) => {
        Available::With($library)
    };
}

/// An enum of words, its conversion to an [`OptionValue`], and the list of its words.
macro_rules! words {
    ($($(#[$doc:meta])* $name:ident {
        $($(#[$word_doc:meta])* $variant:ident = $text:literal $($when:ident $what:literal)?,)+
    })+) => {$(
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        #[non_exhaustive]
        pub enum $name {
            $($(#[$word_doc])* #[doc = concat!("(`", $text, "`", $("; ", stringify!($when), " ", $what,)? ")")] $variant,)+
        }

        impl $name {
            /// All of them.
            pub const ALL: &[Self] = &[$(Self::$variant),+];

            /// As Ipopt writes them, in the order of [`ALL`](Self::ALL).
            pub const WORDS: &[Word] =
                &[$(Word { text: $text, available: available!($($when $what)?) }),+];

            /// As Ipopt writes it.
            pub fn as_str(self) -> &'static str {
                match self { $(Self::$variant => $text),+ }
            }
        }

        impl Setting for $name {
            const WORDS: &'static [Word] = Self::WORDS;
        }

        impl From<$name> for OptionValue {
            fn from(word: $name) -> Self {
                Self::from(word.as_str())
            }
        }
    )+};
}

words! {
    /// How the barrier parameter μ decreases.
    MuStrategy {
        /// Fiacco and McCormick: μ stays until its barrier problem is solved.
        Monotone = "monotone",
        /// A new μ every iteration, from a [`MuOracle`].
        Adaptive = "adaptive",
    }
    /// What chooses μ in the adaptive strategy.
    MuOracle {
        /// Mehrotra's probing heuristic: one more back solve an iteration.
        Probing = "probing",
        /// The centrality rule of LOQO.
        Loqo = "loqo",
        /// The minimum of a quality function.
        QualityFunction = "quality-function",
    }
    /// What chooses μ when the adaptive strategy falls back to the monotone mode.
    FixedMuOracle {
        /// As [`MuOracle::Probing`].
        Probing = "probing",
        /// As [`MuOracle::Loqo`].
        Loqo = "loqo",
        /// As [`MuOracle::QualityFunction`].
        QualityFunction = "quality-function",
        /// The average complementarity.
        AverageComplementarity = "average_compl",
    }
    /// What makes the adaptive strategy converge globally.
    AdaptiveMuGlobalization {
        /// The error of the optimality conditions must decrease.
        KktError = "kkt-error",
        /// A filter of objective and constraint violation.
        Filter = "obj-constr-filter",
        /// Nothing: the monotone mode is never entered.
        Never = "never-monotone-mode",
    }
    /// What solves the linear systems. Ipopt accepts some it lacks, and then ends with
    /// [`Status::InvalidOption`](crate::ipopt::Status::InvalidOption).
    LinearSolver {
        /// MUMPS.
        Mumps = "mumps" with "MUMPS",
        /// HSL MA27.
        Ma27 = "ma27" with "HSL",
        /// HSL MA57.
        Ma57 = "ma57" with "HSL",
        /// HSL MA77, out of core.
        Ma77 = "ma77" with "HSL",
        /// HSL MA86, parallel.
        Ma86 = "ma86" with "HSL",
        /// HSL MA97, parallel.
        Ma97 = "ma97" with "HSL",
        /// Pardiso of pardiso-project.org.
        Pardiso = "pardiso" with "Pardiso",
        /// Pardiso of Intel's MKL.
        PardisoMkl = "pardisomkl" with "MKL (since 3.14.0)",
        /// SPRAL.
        Spral = "spral" with "SPRAL (since 3.14.0)",
        /// WSMP.
        Wsmp = "wsmp" with "WSMP",
    }
    /// How the linear systems are scaled.
    LinearSystemScaling {
        /// Not by Ipopt.
        None = "none",
        /// By HSL MC19.
        Mc19 = "mc19" with "HSL",
        /// By the slacks.
        SlackBased = "slack-based",
    }
    /// Where ∂²L/∂x² comes from.
    HessianApproximation {
        /// From [`Nlp::hessian`](crate::nlp::Nlp::hessian).
        Exact = "exact",
        /// From the gradients of the last iterations.
        LimitedMemory = "limited-memory",
    }
    /// In which variables the Hessian is approximated.
    HessianApproximationSpace {
        /// In those that are not linear; all are taken for nonlinear here.
        NonlinearVariables = "nonlinear-variables",
        /// In all.
        AllVariables = "all-variables",
    }
    /// The least-change update of a limited-memory quasi-Newton approximation.
    LimitedMemoryUpdate {
        /// Broyden, Fletcher, Goldfarb and Shanno: positive definite.
        Bfgs = "bfgs",
        /// Symmetric rank one: may be indefinite.
        Sr1 = "sr1",
    }
    /// The first matrix of a limited-memory approximation, a multiple of the identity: of the last steps s in x and
    /// y in the gradient.
    LimitedMemoryInitialization {
        /// sᵀy / sᵀs.
        Scalar1 = "scalar1",
        /// yᵀy / sᵀy.
        Scalar2 = "scalar2",
        /// The arithmetic mean of both.
        Scalar3 = "scalar3",
        /// The geometric mean of both.
        Scalar4 = "scalar4",
        /// `limited_memory_init_val`.
        Constant = "constant",
    }
    /// What becomes of variables with equal bounds.
    FixedVariableTreatment {
        /// They are taken out of the problem, and their multipliers found afterwards (since 3.14.0).
        MakeParameter = "make_parameter",
        /// They are taken out of the problem, without multipliers.
        MakeParameterNoDual = "make_parameter_nodual" since "3.14.0",
        /// They stay, with an equality constraint each.
        MakeConstraint = "make_constraint",
        /// They stay, with bounds relaxed by `bound_relax_factor`, which wants to be positive for that (this driver's
        /// default is 0). Of their multipliers only z_L − z_U means something. Where equalities outnumber the free
        /// variables, Ipopt does this unasked.
        RelaxBounds = "relax_bounds",
    }
    /// How the problem is scaled.
    NlpScalingMethod {
        /// Not at all.
        None = "none",
        /// By a [`Scaling`](crate::ipopt::Scaling).
        User = "user-scaling",
        /// Down to gradients of `nlp_scaling_max_gradient` at the start.
        GradientBased = "gradient-based",
        /// To rows and columns of like size at random points near the start; needs HSL MC19.
        EquilibrationBased = "equilibration-based",
    }
    /// Which derivatives are compared with finite differences before the solve; see
    /// [`DerivativeCheck`](crate::ipopt::DerivativeCheck).
    DerivativeTest {
        /// None.
        None = "none",
        /// ∇f and ∂g/∂x.
        FirstOrder = "first-order",
        /// Those and ∇²f, ∇²gᵢ; for structures with a Hessian.
        SecondOrder = "second-order",
        /// ∇²f and ∇²gᵢ; for structures with a Hessian.
        OnlySecondOrder = "only-second-order",
    }
    /// What the line search asks of a step.
    LineSearchMethod {
        /// A filter of objective and constraint violation.
        Filter = "filter",
        /// Chen and Goldfarb's penalty function.
        CgPenalty = "cg-penalty",
        /// A penalty function.
        Penalty = "penalty",
    }
    /// The step length of the constraints' multipliers.
    AlphaForY {
        /// That of x.
        Primal = "primal",
        /// That of the bounds' multipliers.
        BoundMultipliers = "bound-mult",
        /// The smaller of the two.
        Min = "min",
        /// The larger of the two.
        Max = "max",
        /// 1.
        Full = "full",
        /// The one that makes ∇L smallest.
        MinDualInfeasibility = "min-dual-infeas",
        /// As before, but between the two others.
        SaferMinDualInfeasibility = "safer-min-dual-infeas",
        /// That of x, and 1 if the step is small.
        PrimalAndFull = "primal-and-full",
        /// That of the bounds' multipliers, and 1 if the step is small.
        DualAndFull = "dual-and-full",
        /// What the acceptor of the line search says.
        Acceptor = "acceptor",
    }
    /// Which constraint violation the column `inf_pr` of the log shows.
    InfPrOutput {
        /// Of the constraints with slacks.
        Internal = "internal",
        /// Of the constraints as given.
        Original = "original",
    }
}
