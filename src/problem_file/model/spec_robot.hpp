#pragma once

#include <filesystem>
#include <map>
#include <variant>

#include <Eigen/Core>

#include "problem_file/model/spec_expression.hpp"
#include "problem_file/model/spec_library.hpp"
#include "problem_file/model/spec_values.hpp"
#include "robot/urdf/urdf.hpp"
#include "systems/closed_forms/catalogue.hpp"
#include "systems/expressions/system.hpp"

namespace conddp {

struct PayloadSpec {
  Name link;
  double mass = 0;                                ///< kg
  std::optional<Name> mass_parameter;             ///< a parameter of the robot, replaces the number
  Vector3<double> com = Vector3<double>::zero();  ///< m, in the link's frame
  std::optional<Symmetric3<double>> inertia;      ///< kg m² about the center of mass
};

/// A frame besides those of the URDF file.
struct FrameSpec {
  Name name;
  Name parent;         ///< a link, a joint, or a frame before it
  PoseSpec placement;  ///< in that
};

struct WrenchSpec {
  Name frame;
  Force<double> wrench = Force<double>::zero();  ///< N, Nm, world-aligned
};

struct ThrusterSpec {
  Name name;
  Name frame;
  Vector3<double> direction{0, 0, 1};  ///< unit vector in the frame
  double torque_ratio = 0;             ///< Nm per N
  double lower = 0;                    ///< N
  double upper = kUnlimited;           ///< N
};

/// `full`: every joint; otherwise thrusters and the named joints (none: `none`).
struct ActuationSpec {
  bool full = true;
  std::vector<ThrusterSpec> thrusters;
  std::vector<Name> joints;
};

struct PassiveSpec {
  bool damping = false;
  bool friction = false;
  double friction_velocity = 0.01;  ///< rad/s or m/s
};

/// A robot from a URDF file.
struct RobotSpec {
  Name name;  ///< of several robots; empty for the only one
  Place place;
  Name urdf;                   ///< as written in the file
  std::filesystem::path path;  ///< resolved against the problem file's folder
  std::optional<Name> srdf;    ///< as written in the file
  std::filesystem::path srdf_path;
  UrdfOptions::Base base = UrdfOptions::Base::fixed;
  std::optional<PoseSpec> placement;
  std::vector<std::pair<Name, StateSpec>> configurations;
  NamedNumbers locked_joints;  ///< rad or m
  NamedNumbers parameters;     ///< constant states with their initial values
  std::vector<PayloadSpec> payloads;
  std::vector<FrameSpec> frames;
  std::vector<WrenchSpec> external_wrenches;
  NamedNumbers rotor_inertia;  ///< kg m² or kg
  ActuationSpec actuation;
  PassiveSpec passive;
  bool enforce_mimic = false;
  UrdfOptions::Inertias inertias = UrdfOptions::Inertias::as_given;
};

struct DoubleIntegratorSpec {
  int dimension = 1;
};
struct LinearSpec {
  SystemKind gives = SystemKind::discrete;  ///< or rate (first order)
  Eigen::MatrixXd A, B;
  Eigen::VectorXd c;
};
struct UnicycleSpec {};
struct CarSpec {
  double wheelbase = 2;  ///< m
};

/// Places of the names and texts of one part of a system of expressions.
struct SystemPartPlaces {
  std::vector<Place> names;
  std::vector<ExpressionText> texts;
};

/// A system of expressions, with the parsed text.
struct ExpressionSystemSpec {
  ExpressionSystemText text;
  ExpressionNamesSpec own;  ///< constants and tables of the text, in addition to those of the file
  std::map<ModelMessage::Part, SystemPartPlaces> places;
  ParsedExpressionSystem parsed;
};

/// A closed-form system.
struct SystemSpec {
  Place place;
  std::variant<DoubleIntegratorSpec, LinearSpec, PendulumParameters, CartpoleParameters,
               AcrobotParameters, UnicycleSpec, CarSpec, PlanarQuadrotorParameters,
               QuadrotorParameters, LanderParameters, ExpressionSystemSpec, LibrarySystemSpec>
      parameters;
};

/// One of several systems; phases select one by name.
struct NamedSystemSpec {
  Name name;
  SystemSpec system;
};

}  // namespace conddp
