#pragma once

#include <algorithm>
#include <string>

#include "problem_file/model/spec.hpp"
#include "problem_file/model/spec_gait.hpp"
#include "problem_file/yaml/yaml_reader.hpp"

namespace conddp {

/// Spellings of enumerated keys, for reading and printing.

namespace detail {

constexpr bool has_name(const IntegratorInfo& info) { return !info.name.empty(); }
inline constexpr auto kNamedIntegrators = std::ranges::count_if(kIntegrators, has_name);

struct IntegratorWords {
  constexpr IntegratorWords() {
    int at = 0;
    for (const IntegratorInfo& info : kIntegrators)
      if (has_name(info)) words[at++] = {info.name, info.integrator, info.description};
  }
  Choice<Integrator> words[kNamedIntegrators];
};
inline constexpr IntegratorWords kIntegratorWords;

}  // namespace detail

/// Integrators that a file can name.
inline constexpr auto& kIntegratorWords = detail::kIntegratorWords.words;

inline constexpr Choice<ControlCourse> kControlCourseWords[] = {
    {"constant", ControlCourse::kConstant}, {"linear", ControlCourse::kLinear}};
inline constexpr Choice<RunningCosts> kRunningCostsWords[] = {
    {"rate", RunningCosts::kRate},
    {"integrated", RunningCosts::kIntegrated},
    {"sum", RunningCosts::kSum}};

/// True if a constraint also applies to the nodes at the end of its phases.
inline constexpr Choice<bool> kNodesWords[] = {{"begins", false}, {"ends", true}};

/// Output of a compiled function.
inline constexpr Choice<SystemKind> kLibraryAnswerWords[] = {
    {"rate", SystemKind::first_order},
    {"acceleration", SystemKind::second_order},
    {"next", SystemKind::discrete}};

/// Output of the matrices of a linear system.
inline constexpr Choice<SystemKind> kLinearAnswerWords[] = {{"next", SystemKind::discrete},
                                                            {"rate", SystemKind::first_order}};

inline constexpr Choice<UrdfOptions::Base> kBaseWords[] = {
    {"fixed", UrdfOptions::Base::fixed},
    {"floating", UrdfOptions::Base::floating},
    {"planar", UrdfOptions::Base::planar}};

inline constexpr Choice<bool> kPassiveWords[] = {{"none", false}, {"urdf", true}};
inline constexpr Choice<UrdfOptions::Inertias> kInertiasWords[] = {
    {"as_given", UrdfOptions::Inertias::as_given}, {"strict", UrdfOptions::Inertias::strict}};
inline constexpr Choice<bool> kMimicWords[] = {{"ignore", false}, {"enforce", true}};
inline constexpr Choice<bool> kActuationWords[] = {{"full", true}, {"none", false}};

inline constexpr Choice<FrameAxes> kAxesWords[] = {{"local", FrameAxes::local},
                                                   {"world", FrameAxes::world_aligned}};

inline constexpr Choice<ContactKind> kContactWords[] = {{"point", ContactKind::point},
                                                        {"surface", ContactKind::surface},
                                                        {"normal", ContactKind::normal},
                                                        {"planar", ContactKind::planar}};

inline constexpr Choice<GaitType> kGaitWords[] = {
    {"stand", GaitType::stand}, {"walk", GaitType::walk},   {"trot", GaitType::trot},
    {"pace", GaitType::pace},   {"bound", GaitType::bound}, {"jump", GaitType::jump}};

inline constexpr Choice<SteppingScheme> kSchemeWords[] = {
    {"backward_euler", SteppingScheme::backward_euler},
    {"variational_midpoint", SteppingScheme::variational_midpoint}};
/// Friction bounds of contact-implicit steps.
inline constexpr Choice<FrictionModel> kFrictionWords[] = {
    {"polyhedron", FrictionModel::polyhedron}, {"cone", FrictionModel::cone}};
/// True if all joint limits of the URDF are stops.
inline constexpr Choice<bool> kJointLimitWords[] = {{"none", false}, {"urdf", true}};

/// True for a second-order friction cone.
inline constexpr Choice<bool> kConeWords[] = {{"pyramid", false}, {"second_order", true}};

inline constexpr Choice<PairsSpec::Choice> kPairsWords[] = {
    {"obstacles", PairsSpec::Choice::kObstacles, "every shape against every obstacle"},
    {"self", PairsSpec::Choice::kSelf,
     "every two shapes but those on one link or on links that a joint connects"},
    {"all", PairsSpec::Choice::kAll, "both"}};

inline constexpr Choice<GuessSpec::States> kStatesGuessWords[] = {
    {"initial", GuessSpec::States::kInitial}, {"interpolate", GuessSpec::States::kInterpolate}};

inline constexpr Choice<Interpolation> kInterpolationWords[] = {
    {"linear", Interpolation::kLinear, "straight from one to the next, rotations the shortest way"},
    {"cubic", Interpolation::kCubic, "by a natural cubic spline"}};

inline constexpr Choice<GuessSpec::Controls> kControlsGuessWords[] = {
    {"zero", GuessSpec::Controls::kZero},
    {"quasi_static", GuessSpec::Controls::kQuasiStatic},
    {"gravity", GuessSpec::Controls::kQuasiStatic}};

inline constexpr Choice<SamplingMethod> kSamplingWords[] = {
    {"predictive", SamplingMethod::predictive, "constant noise around the best sample so far"},
    {"cem", SamplingMethod::cem, "a normal distribution fitted to the best tenth of a round"},
    {"mppi", SamplingMethod::mppi, "constant noise around a weighted mean"}};

inline constexpr Choice<BoundedQuantity> kBoundedWords[] = {
    {"control", BoundedQuantity::kControl,
     "bounds on the controls at every knot; needs 'lower', 'upper' or 'from: urdf'"},
    {"state", BoundedQuantity::kState,
     "bounds on coordinates of the state at every node; needs the same"},
    {"configuration", BoundedQuantity::kConfiguration, "the same of positions"},
    {"velocity", BoundedQuantity::kVelocity, "the same of velocities"}};

inline constexpr Choice<Softness> kSoftWords[] = {
    {"l1", Softness::l1,
     "weight times the distance: exact, it holds wherever its multiplier stays below the weight"},
    {"l2", Softness::l2, "half the weight times the squared distance: smooth, and never exact"}};

inline constexpr Choice<AfterTheEnd> kRepeatWords[] = {
    {"hold", AfterTheEnd::kHold, "the last knot repeats itself after the end of the phases"},
    {"none", AfterTheEnd::kNone, "horizons shrink to the end of the phases"},
    {"gait", AfterTheEnd::kGait, "the gait gets as many cycles as the loop needs"}};

inline constexpr Choice<WindowEnd> kWindowEndWords[] = {
    {"none", WindowEnd::kNothing, "nothing counts there"},
    {"keep", WindowEnd::kTerminal, "the costs and constraints of `terminal` count there"}};

inline constexpr Choice<bool> kSwingStartWords[] = {
    {"planned", false, "at their footholds"},
    {"measured", true, "where the feet are when they lift off"}};

/// The first spelling of a value; empty if the table does not contain the value.
template <class E, std::size_t N>
std::string word_of(const Choice<E> (&table)[N], E value) {
  for (const Choice<E>& entry : table)
    if (entry.value == value) return std::string(entry.word);
  return {};
}

}  // namespace conddp
