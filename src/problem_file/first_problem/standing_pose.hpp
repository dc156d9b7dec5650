#pragma once

#include "problem_file/first_problem/robot_survey.hpp"

namespace conddp {

/// Moves the posture of a robot with feet into a stand, unless an SRDF gave one: knees bent, feet
/// flat and at one height below their hips, two feet under the center of mass. Then places the base
/// upright over the origin with the feet at height 0. Numbers are rounded to those of a file.
void stand_up(RobotSurvey& survey);

/// Rounded to four decimals, as numbers of a first problem are: 0.1 mm, 0.006 degrees.
double rounded(double number);

/// Poses of the feet in the survey's posture.
std::vector<SE3<double>> placements_of_feet(const RobotSurvey& survey);

}  // namespace conddp
