#include "report_file.hpp"

#include "embedded_report.hpp"
#include "messages.hpp"
#include "output/atomic_file.hpp"

namespace conddp {

bool reports_can_be_made() {
  if (missing_for_reports().empty()) return true;
  print_error("reports cannot be made: " + std::string(missing_for_reports()),
              "install nodejs and npm (scripts/setup does), connect to the network, build again");
  return false;
}

std::string write_report(const OrderedJson& data, const std::filesystem::path& file) {
  AtomicFiles files;
  files.add(file, report_page(std::string(report_template()), data));
  files.commit();
  return file.string();
}

}  // namespace conddp
