#pragma once

#include "analysis/contact/contact_motion.hpp"
#include "base/json/ordered_json.hpp"

namespace conddp {

/// Contacts found by a contact-implicit motion, in the form used by reports.
struct FoundContacts {
  /// In the form of motion_scene(). The force of a pair acts on the sphere, or on its counterpart
  /// if the sphere is fixed to the world.
  OrderedJson contacts = OrderedJson::array();
  /// By name: per knot of the problem the force in world axes (N, mean over the step); null if
  /// negligible (ContactSequenceOptions::share).
  OrderedJson forces = OrderedJson::object();
};

FoundContacts found_contacts(const ContactMotion& motion);

}  // namespace conddp
