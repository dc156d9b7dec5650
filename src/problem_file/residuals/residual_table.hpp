#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "problem_file/model/residual_definition.hpp"

namespace conddp {

/// The definitions of residuals, one family per file.
std::span<const ResidualDefinition> state_residuals();
std::span<const ResidualDefinition> control_residuals();
std::span<const ResidualDefinition> joint_residuals();
std::span<const ResidualDefinition> frame_residuals();
std::span<const ResidualDefinition> whole_body_residuals();
std::span<const ResidualDefinition> force_residuals();
std::span<const ResidualDefinition> distance_residuals();
std::span<const ResidualDefinition> contact_velocity_residuals();
std::span<const ResidualDefinition> cycle_residuals();
std::span<const ResidualDefinition> combination_residuals();
std::span<const ResidualDefinition> expression_residuals();
std::span<const ResidualDefinition> library_residuals();

/// Families in the order of the documents.
inline constexpr std::span<const ResidualDefinition> (*kResidualFamilies[])() = {
    state_residuals,      control_residuals,     joint_residuals,      frame_residuals,
    whole_body_residuals, force_residuals,       distance_residuals,   contact_velocity_residuals,
    cycle_residuals,      combination_residuals, expression_residuals, library_residuals};

/// All definitions.
const std::vector<const ResidualDefinition*>& residual_table();
/// The definition with this name, or null.
const ResidualDefinition* find_residual(std::string_view name);
/// The keys of all residuals, each once.
const std::vector<const ResidualKey*>& residual_keys();

}  // namespace conddp
