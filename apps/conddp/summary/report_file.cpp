#include "summary/embedded_report.hpp"
#include "summary/summary.hpp"
#include "terminal/messages.hpp"

namespace conddp {

bool reports_can_be_made() {
  if (missing_for_reports().empty()) return true;
  print_error("reports cannot be made: " + std::string(missing_for_reports()),
              "install nodejs and npm (scripts/setup does), connect to the network, build again");
  return false;
}

std::string report_text(const OrderedJson& data) {
  return report_page(std::string(report_template()), data);
}

}  // namespace conddp
