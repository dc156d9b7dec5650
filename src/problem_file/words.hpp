#pragma once

#include <string>

#include "problem_file/spec.hpp"
#include "problem_file/yaml_reader.hpp"

namespace conddp {

/// The words of enumerated keys, for reading and for printing.

inline constexpr Choice<Integrator> kIntegratorWords[] = {
    {"semi_implicit_euler", Integrator::semi_implicit_euler},
    {"explicit_euler", Integrator::explicit_euler},
    {"rk2", Integrator::rk2},
    {"rk3", Integrator::rk3},
    {"rk4", Integrator::rk4},
    {"discrete", Integrator::discrete}};

inline constexpr Choice<RunningCosts> kRunningCostsWords[] = {{"rate", RunningCosts::kRate},
                                                              {"sum", RunningCosts::kSum}};

inline constexpr Choice<UrdfOptions::Base> kBaseWords[] = {
    {"fixed", UrdfOptions::Base::fixed},
    {"floating", UrdfOptions::Base::floating},
    {"planar", UrdfOptions::Base::planar}};

inline constexpr Choice<bool> kPassiveWords[] = {{"none", false}, {"urdf", true}};
inline constexpr Choice<bool> kMimicWords[] = {{"ignore", false}, {"enforce", true}};
inline constexpr Choice<bool> kActuationWords[] = {{"full", true}, {"none", false}};

inline constexpr Choice<ActivationKind> kActivationWords[] = {
    {"quadratic", ActivationKind::quadratic},
    {"quadratic_barrier", ActivationKind::quadratic_barrier},
    {"smooth_l1", ActivationKind::smooth_l1},
    {"smooth_l2", ActivationKind::smooth_l2}};

inline constexpr Choice<FrameAxes> kAxesWords[] = {{"local", FrameAxes::local},
                                                   {"world", FrameAxes::world_aligned}};

inline constexpr Choice<GuessSpec::States> kStatesGuessWords[] = {
    {"initial", GuessSpec::States::kInitial}, {"interpolate", GuessSpec::States::kInterpolate}};

inline constexpr Choice<GuessSpec::Controls> kControlsGuessWords[] = {
    {"zero", GuessSpec::Controls::kZero},
    {"quasi_static", GuessSpec::Controls::kQuasiStatic},
    {"gravity", GuessSpec::Controls::kQuasiStatic}};

/// The first word of a value; empty if it has none.
template <class E, std::size_t N>
std::string word_of(const Choice<E> (&table)[N], E value) {
  for (const Choice<E>& entry : table)
    if (entry.value == value) return std::string(entry.word);
  return {};
}

}  // namespace conddp
