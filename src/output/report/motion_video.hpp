#pragma once

#include <functional>
#include <string>

#include "output/report/browser.hpp"

namespace conddp {

/// The motion in a report's page as a WebM file of 1280x720 pixels and 30 frames a second. Throws
/// OutputError if the browser fails. `on_progress` receives the share that is done.
std::string record_motion(const std::string& page, const BrowserOptions& options,
                          const std::function<void(double)>& on_progress);

}  // namespace conddp
