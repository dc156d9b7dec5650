#pragma once

#include <string>
#include <vector>

namespace conddp {

/// A case of a test report.
struct JunitCase {
  std::string name;
  double time_s = 0;
  std::vector<std::string> failures;  ///< what does not hold, a line each
  std::string error;                  ///< why it could not be tested, may be empty
};

/// A test report in the XML that JUnit made common, as CI servers read it. Characters that XML
/// cannot hold become '?'.
std::string junit_xml(const std::string& suite, const std::vector<JunitCase>& cases);

}  // namespace conddp
