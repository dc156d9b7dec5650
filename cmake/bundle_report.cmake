# cmake -D SOURCE=<apps/report> -D WORK=<folder> -D NPM=<npm or -NOTFOUND> -D NODE=<node or -NOTFOUND>
#       -D OUTPUT=<file.cpp> -P bundle_report.cmake
# Bundles the page of reports and writes the source that holds it; apps/conddp/summary/embedded_report.hpp
# declares it. What is missing for that is no error: the tool says it when a report is asked for.
set(page "")
set(missing "")

if(NOT NODE OR NOT NPM)
  set(missing "Node.js and npm were not found when conddp was built")
else()
  file(COPY ${SOURCE}/ DESTINATION ${WORK} PATTERN node_modules EXCLUDE)
  execute_process(
    COMMAND ${NPM} ci --ignore-scripts --no-audit --no-fund --fetch-retries=1 --fetch-timeout=20000
    WORKING_DIRECTORY ${WORK} RESULT_VARIABLE failed OUTPUT_VARIABLE log ERROR_VARIABLE log)
  if(failed)
    set(missing "npm could not fetch the report's packages when conddp was built")
  else()
    execute_process(
      COMMAND ${NODE} build.mjs page.html
      WORKING_DIRECTORY ${WORK} RESULT_VARIABLE failed OUTPUT_VARIABLE log ERROR_VARIABLE log)
    if(failed)
      message(FATAL_ERROR "the page of reports cannot be bundled:\n${log}")
    endif()
  endif()
endif()

if(missing STREQUAL "")
  file(SIZE ${WORK}/page.html size)
  file(READ ${WORK}/page.html bytes HEX)
  string(REGEX REPLACE "(................................)" "\\1\n" bytes "${bytes}")
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${bytes}")
  set(page "${bytes}")
else()
  message(WARNING "${missing}; 'conddp report' will say so. ${log}")
  set(size 0)
  set(page "0")
endif()

file(WRITE ${OUTPUT} "// Written by cmake/bundle_report.cmake.
#include \"summary/embedded_report.hpp\"

namespace conddp {
namespace {

constexpr unsigned char kPage[] = {
${page}};

}  // namespace

std::string_view report_template() { return {reinterpret_cast<const char*>(kPage), ${size}}; }

std::string_view missing_for_reports() { return \"${missing}\"; }

}  // namespace conddp
")
if(NOT missing STREQUAL "")
  # Older than everything, so that the next build tries again.
  execute_process(COMMAND touch -d 2000-01-01 ${OUTPUT})
endif()
