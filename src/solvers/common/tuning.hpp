#pragma once

#include <limits>

/// Every tuned number of the solvers, by subject. Papers are listed at the end of docs/solvers.md;
/// "ablations" is docs/measurements/ablations.md. `scripts/check_layers` refuses such numbers in
/// other files of the layer. Limits of formats, sizes of arrays and tiles, and constants of
/// mathematics stay where they are used.
namespace conddp::tuning {

// Rounding.
/// A change is visible from this multiple of its estimated rounding on, as Ipopt assumes; a
/// residual is violated from this multiple of its tolerance on.
inline constexpr double kVisible = 10;
/// Numbers that differ by this share differ by rounding of the last operations.
inline constexpr double kUlps = kVisible * std::numeric_limits<double>::epsilon();
/// Sums that differ by this share of their largest term differ by rounding. Newton's method ends at
/// norms of this size.
inline constexpr double kRounding = 1e-12;
/// Equations that hold to this share of their largest term count as exact: dependent rows, affine
/// models, rows of the horizon QP.
inline constexpr double kExact = 1e-9;
/// Curvatures below this one count as none.
inline constexpr double kLeastCurvature = 1e-6;
/// Larger stationarities and gaps mean divergence.
inline constexpr double kLargestStationarity = 1e16, kLargestGap = 1e10;

// Rates of loops.
/// Goals and relaxations tighten by this factor (Howell et al. 2019; Raghunathan, Biegler 2005).
inline constexpr double kTighter = 0.1;
/// An update that leaves more than this share of a residual makes no progress.
inline constexpr double kProgress = 0.5;
/// A loop ends after this number of tries.
inline constexpr int kTries = 20;
/// A further solve may take this number of iterations at least.
inline constexpr int kLeastLimit = 50;

// Searches (Nocedal, Wright 2006, section 3.1).
/// Share of the first-order decrease that a step has to reach.
inline constexpr double kArmijo = 1e-4;
/// Shortest step. Where steps of a thousandth fail, more regularization also turns the step and is
/// the better next trial.
inline constexpr double kLeastStep = 1e-4;
/// Shortest step that is compared with a longer one, that Newton's method takes, or that the
/// stationarity judges.
inline constexpr double kShortestHalf = 0.125;
/// Factor by which the stationarity falls in a step that it judges.
inline constexpr double kBlindProgress = 0.999;
/// Range of the decrease of a quadratic function, as a share of the first-order decrease; a perfect
/// model gives ½.
inline constexpr double kQuadraticFrom = 0.3, kQuadraticTo = 0.8;

// Open gaps (ablations: robustness to far-away starts, steps that open gaps).
/// Share of the gaps' weight that covers the cost of the model's step; the rest is decrease
/// (Nocedal, Wright 2006, equation 18.36).
inline constexpr double kGapShare = 0.65;
/// A rollout that reaches this share of the model's decrease makes another trial unnecessary.
inline constexpr double kConvincing = 0.6;
/// Growth of the gaps by a linear step. If the model's cost falls with its gaps, their weight is
/// zero, and nothing else limits them.
inline constexpr double kMostGapGrowth = 1.5;
/// Gap from which on exact Hessians serve stages that enforce rows: linear steps close these gaps
/// only at the end.
inline constexpr double kNearlyClosed = 1e-3;

// Full steps with second-order corrections (Nocedal, Wright 2006, section 18.3).
/// Weight of the gaps of a step, and weight that needs no correction, as shares of the expected
/// decrease.
inline constexpr double kMostGaps = 0.5, kNegligibleGaps = 0.1;
/// Corrections of a step.
inline constexpr int kCorrections = 3;

// Regularization (Tassa et al. 2012, section II-F).
/// It falls after steps of the first length and rises after steps of the second. A decrease by
/// shorter ones means nothing to an outer loop, shorter directions need no L-BFGS correction.
inline constexpr double kLongStep = 0.5, kShortStep = 0.2;
/// Factor on its rate of change, and its smallest value.
inline constexpr double kRegularizationFactor = 2, kLeastRegularization = kLeastCurvature;
/// Largest value for the sake of a settled active set (ablations: regularization while the active
/// set changes).
inline constexpr double kSettlingRegularization = 0.01;

// Hessians.
/// L-BFGS (ablations: parts of the loop): pairs, and ratio of curvatures or slopes beyond which
/// steps are too large for a quadratic model.
inline constexpr int kPairs = 5;
inline constexpr double kLargestFactor = 2.5;
/// Directions of a knot from which on exact Hessians are expensive.
inline constexpr int kDearDirections = 30;
/// Iterations over which convergence is judged, with Gauss-Newton's and with exact Hessians
/// (ablations: exact Hessians when slow).
inline constexpr int kWatchedIterations = 10, kFewestExact = 8;
/// Exact iterations that a solve is assumed to need; their number before they are judged, in units
/// of Gauss-Newton iterations.
inline constexpr double kExactIterations = 4, kExactTrial = 1000;
/// Steps of Ipopt (docs/measurements/transcription.md, Hessians): trials and growth of the error
/// that make a step poor, poor steps that end the use of Gauss-Newton's Hessians, iterations in
/// which the error has to tighten.
inline constexpr int kPoorTrials = 3, kPoorSteps = 2, kWatchedIpopt = 5;
inline constexpr double kPoorGrowth = 2;

// The horizon QP (ablations: sweeps while the active set changes).
/// Revisions without fewer changes of the active set, and sweeps of a search.
inline constexpr int kRevisions = 4, kSweeps = 20;
/// Sweeps that real-time iterations may begin on average before their searches end. Nearly all take
/// one or two.
inline constexpr int kRealTimeSweeps = 6;
/// Error of the rows' model at a step, squared in the norm of the Hessian, as a share of dᵀHd.
inline constexpr double kModelError = 1e-6;
/// Error of a cone's model as a share of its own values: random conic problems of full size take up
/// to 89 iterations in place of 60 without it.
inline constexpr double kConeShare = 0.02;
/// A descent: ρ of control bounds in multiples of the stages' curvature, and share of the slope
/// that a line search leaves.
inline constexpr double kControlWeight = 10, kSlopeLeft = 1e-3;

// Augmented Lagrangian (Howell et al. 2019; Conn, Gould, Toint 1991).
/// Stationarity and relative decrease that end the first minimization, and last decrease.
inline constexpr double kFirstInnerTolerance = 0.1, kFirstInnerDecrease = 1e-3,
                        kLastInnerDecrease = 1e-8;
/// Gaps of a finished minimization, as a share of its violation.
inline constexpr double kGapsOfViolation = 0.01;
/// Gain of a step in a finished minimization, in multiples of the gain by new multipliers.
inline constexpr double kDualShare = 10;
/// Rounding stops a minimization whose goal is this share of the stationarity tolerance.
inline constexpr double kHopelessGoal = 1e-6;
/// Growths of a penalty without progress that mean infeasibility, unless rounding explains the
/// violation.
inline constexpr int kGrowths = 6;
inline constexpr double kContradiction = 1e-5;
/// First penalties: violation of a soft constraint in multiples of its first values, and largest
/// penalty in multiples of the costs' curvature in the controls. Stiffer rows keep the active set
/// from settling.
inline constexpr double kReach = 10, kStiffness = 1e4;

// Projected Newton (ablations: Newton's Hessian).
/// It begins below these norms.
inline constexpr double kNewtonFrom = 3e-3;
/// Damped steps of a try, relative decrease of the norms by a full step, and their growth by a step
/// that changes many active rows.
inline constexpr int kDampedSteps = 2;
inline constexpr double kNewtonDecrease = 0.1, kNewtonGrowth = 10;
/// ρ of active rows, in multiples of the largest curvature.
inline constexpr double kRowPenalty = 1e5;

// Convergence (docs/measurements/verdicts.md).
/// Part that is asked of a stationarity that should suffice, and smallest goal as a share of the
/// tolerance.
inline constexpr double kGoalMargin = 0.5, kLeastGoal = 1e-5;
/// Distance of co-states from those along other gains, relative to the largest of these, in
/// stationarity tolerances: gains that add up over the horizon cause such distances. With
/// constraints, largest share of the cost's derivative that may be left as stationarity.
inline constexpr double kCostateTolerance = 500, kShareOfCost = 0.01;
/// Share of the cost that may be left to gain, also at the least goal, and by which a better answer
/// is better.
inline constexpr double kMostGain = 1e-4, kMostGainAtEnd = 10 * kMostGain;
/// Iterations that settle a cost.
inline constexpr int kSettledSteps = 3;

// Restoration.
/// The first ρ makes the violation this many times as large as the cost; growth and limit of ρ.
inline constexpr double kFirstWeight = 10, kPenaltyFactor = 100, kMostPenalty = 1e12;
/// Share of the violation that is left of a restored one, or by which a lower one is lower.
inline constexpr double kRestored = 0.01;
/// Share of the violation that moves may remove from a least one (ViolationSlope), and from that of
/// a finished minimization; relative decrease that finishes one, too.
inline constexpr double kLeastShare = 5e-3, kMinimizedShare = 5e-4, kSmallDecrease = 1e-7;
/// Violation on the motion of the controls, in multiples of that at the given states.
inline constexpr double kSimulated = 10;
/// Restorations of a solve, and solves after an infeasible answer.
inline constexpr int kRestorations = 3;

// Ipopt.
/// Rotation from the center of a chart, rad, from which on the iterate becomes the center; charts
/// end at π.
inline constexpr double kLargestAngle = 2;
/// Ipopt's own first barrier and push off bounds, and those of a continued solve.
inline constexpr double kColdBarrier = 0.1, kColdPush = 0.01, kWarmBarrier = 1e-9;
/// First multipliers: weight of the equations of cost states, and largest useful multiplier.
inline constexpr double kCostStatesFirst = 1e6, kLargestFirst = 1e3;
/// Smallest curvature in comparisons of multipliers with distances from a bound: those of thrusts
/// in kilonewtons are as small.
inline constexpr double kSmallestCurvature = 1e-8;
/// Factor on the tolerances after an answer that was not good enough.
inline constexpr double kRefinement = 0.01;
/// Relaxed pairs (docs/measurements/contact_implicit.md): largest tolerance of a solve, push off
/// bounds as a share of its epsilon.
inline constexpr double kLooseTolerance = 1e-3, kPushShare = 0.01;
/// Failures that end a relaxation; its part of the iterations, at least this number; iterations of
/// a trial with fixed pairs.
inline constexpr int kFailures = 2, kWays = 2, kEnough = 300, kPolishIterations = 40;

// Strategies (docs/measurements/hard_cases.md).
/// Costs and violations that differ by less than this share are equal, and trajectories by less
/// than that share of their extent.
inline constexpr double kEqualCost = 1e-6, kEqualStates = 0.01;
/// Starts that end at the same least violation before it counts as a property of the constraints.
inline constexpr int kAlikeStarts = 5;
/// Spreads of guesses far from a failed one: near ones lead to the same answer.
inline constexpr double kFarSpread = 1, kFartherSpread = 10;
/// Guesses that are tried in parallel, and iterations of a try in multiples of the best one's.
inline constexpr int kBeside = 2, kTimes = 4;
/// Solves that may answer objections, and excess that is worth the iterations of the first solve.
inline constexpr int kRounds = 6;
inline constexpr double kExcess = 100;
/// Factor on a first penalty that releases constraints.
inline constexpr double kStronger = 1e3;
/// First and shortest step of a homotopy.
inline constexpr double kFirstShare = 0.25, kLeastShareStep = 1.0 / 512;
/// Binary logarithms: usual sizes, sizes that lie far apart, limit of all sizes.
inline constexpr double kUsualSizes = 5, kFarSizes = 13, kMostSizes = 40;

// Starts by sampling (docs/measurements/sampling.md).
/// Standard deviation of the noise, as a share of half the control range.
inline constexpr double kNoiseShare = 0.2;
/// Square root of the growth of penalties per squared round (Joines, Houck 1994).
inline constexpr double kPenaltyRate = 0.5;
/// Share of the samples from which a distribution is fitted (de Boer et al. 2005), and exponent of
/// the weight of a sample (Theodorou et al. 2010, section 3.2).
inline constexpr double kEliteShare = 0.1, kPathSharpness = 10;

// Interior points (Wächter, Biegler 2006; docs/measurements/contact_implicit.md).
namespace interior {
/// First barrier, barrier at which the smaller entries of pairs are held, and barriers from which
/// Newton's method is tried: a smaller one separates active bounds from others more clearly.
/// Distance and multiplier of a bound that is neither are √μ.
inline constexpr double kFirstBarrier = 1e-2, kPairBarrier = 1e-7;
inline constexpr double kLastBarriers[] = {1e-9, 1e-12, 1e-15};
/// Barrier of real-time iterations, and distance of their guesses from bounds.
inline constexpr double kTickBarrier = 1e-4;
/// A barrier problem counts as solved if its error is below this multiple of the barrier (equation
/// 7); residuals need not be smaller than the third number. The next barrier is the second's share:
/// faster reductions lose the path on which contacts change.
inline constexpr double kSolved = 10, kLower = 0.2, kExact = 1e-10;
/// Least first relaxation of pairs (ablations: interior points), and the factors of those that are
/// tried. While another one remains, a solve may take 1/kTryShare of the iterations, but at least
/// kEnough.
inline constexpr double kWideRelaxation = 3;
inline constexpr double kFirstRelaxations[] = {1, kTighter, kTighter* kTighter};
inline constexpr int kTryShare = 4;
/// Costs whose first derivatives are larger than this have a larger first barrier; multipliers
/// whose mean is larger have a larger penalty and larger errors (section 2.1).
inline constexpr double kLargeGradient = 100;
/// Iterations with one barrier before exact Hessians replace convex ones, if they are expensive.
inline constexpr int kGaussNewton = 40;
/// Largest gap at which exact Hessians are used, unless costs are linear: then no other Hessian has
/// their curvature.
inline constexpr double kLargestGap = 0.1;
/// Step lengths tried along a direction, and directions tried for one step.
inline constexpr int kTriedLengths = 12, kTriedDirections = 12;
/// Regularization: weight after a failed search, factors of its changes, limit below which a weight
/// vanishes, least weight where a stage lacks a minimum (and barrier whose curvature rounding
/// hides), largest weight.
inline constexpr double kFirstWeight = 1e-4, kHeavier = 10, kLighter = 0.2, kNoWeight = 1e-5,
                        kLeastWeight = 1e-6, kLargestWeight = 1e10;
/// The weight falls after a longer step than the first; kTries steps in a row that are shorter than
/// the second end a solve.
inline constexpr double kLongStep = 0.1, kShortStep = 1e-3;
/// Penalty ρ of equalities, in multiples of the size of multipliers: six of sixteen digits, so that
/// steps satisfy equations to six digits and keep ten.
inline constexpr double kPenalty = 1e6;
/// Share of the curvature of a pair's own terms that the product's may use up.
inline constexpr double kPairShare = 0.9;
/// Share of its limit that a soft term's first multiplier may reach.
inline constexpr double kSoftShare = 0.5;
/// Distance of the first iterate from its bounds, relative to them and to their width (section
/// 3.6).
inline constexpr double kInside = 0.1;
/// A step leaves this share of slacks and multipliers. Less of it lets small barriers come too near
/// to the wrong bounds.
inline constexpr double kLeft = 0.01;
/// Times that the filter of a barrier problem may be forgotten.
inline constexpr int kForgotten = 5;
/// A multiplier stays within this factor of μ/s (equation 16).
inline constexpr double kCentral = 1e10;
/// The filter's constants of section 4.1, with their names.
inline constexpr double kGammaTheta = 1e-5, kGammaPhi = 1e-8, kEtaPhi = 1e-4, kThetaPower = 1.1,
                        kPhiPower = 2.3, kThetaMin = 1e-4, kThetaMax = 1e4;
}  // namespace interior

}  // namespace conddp::tuning
