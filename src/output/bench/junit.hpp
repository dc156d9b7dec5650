#pragma once

#include <string>
#include <vector>

namespace conddp {

/// A case of a test report.
struct JunitCase {
  std::string name;
  double time_s = 0;
  std::vector<std::string> failures;  ///< violated expectations, one per line
  std::string error;                  ///< reason why the case could not be tested, may be empty
};

/// A test report in the JUnit XML format of CI servers. Characters that XML cannot represent become
/// '?'.
std::string junit_xml(const std::string& suite, const std::vector<JunitCase>& cases);

}  // namespace conddp
