#pragma once

#include "analysis/contact/contact_motion.hpp"
#include "base/json/json_text.hpp"

namespace conddp {

/// The contacts of a motion that found them, as reports show contacts.
struct FoundContacts {
  /// As motion_scene() lists them. The force of a pair is that on the sphere; on what it touches
  /// where the sphere is fixed to the world.
  OrderedJson contacts = OrderedJson::array();
  /// By name: per knot of the problem the force in world axes (N, mean over the step), null where
  /// it is none that counts (ContactSequenceOptions::share).
  OrderedJson forces = OrderedJson::object();
};

FoundContacts found_contacts(const ContactMotion& motion);

}  // namespace conddp
