#pragma once

#include <span>
#include <string_view>

#include "solvers/iterate/ddp_recipe.hpp"

namespace conddp {

/// A solver of the DDP family: the common sweep and loop (DdpSolver) with its own recipe.
struct DdpMember {
  std::string_view name;
  std::string_view description;  ///< one line
  DdpRecipe recipe;
};

/// All members, in the order of the documentation. The recipe determines what a member supports;
/// another row adds another solver.
std::span<const DdpMember> ddp_family();
/// The member with this name, or null.
const DdpMember* find_ddp_member(std::string_view name);

}  // namespace conddp
