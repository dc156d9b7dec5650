#pragma once

#include <span>
#include <string_view>

#include "solvers/iterate/ddp_recipe.hpp"

namespace conddp {

/// A solver of the DDP family: one sweep and one loop (DdpSolver), with its own choices.
struct DdpMember {
  std::string_view name;
  std::string_view description;  ///< one line
  DdpRecipe recipe;
};

/// All of them, in the order in which documents list them. What a member supports follows from its
/// recipe; a row more is a solver more.
std::span<const DdpMember> ddp_family();
/// The one of this name, or null.
const DdpMember* find_ddp_member(std::string_view name);

}  // namespace conddp
