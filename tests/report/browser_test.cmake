# cmake -D SOURCE=<tests/report> -D WORK=<folder> -D NODE= -D NPM= -D CHROMIUM= -D CONDDP=<tool>
#       -D ROOT=<source tree> -P browser_test.cmake
# Installs the browser driver at the versions of package-lock.json and runs *.test.mjs.
file(COPY ${SOURCE}/ DESTINATION ${WORK} PATTERN node_modules EXCLUDE)
execute_process(
  COMMAND ${NPM} ci --ignore-scripts --no-audit --no-fund
  WORKING_DIRECTORY ${WORK} RESULT_VARIABLE failed)
if(failed)
  message(FATAL_ERROR "npm could not fetch the packages of the browser tests")
endif()
execute_process(
  COMMAND ${CMAKE_COMMAND} -E env CONDDP=${CONDDP} CONDDP_SOURCE=${ROOT}
    CONDDP_CHROMIUM=${CHROMIUM} ${NODE} --test --test-reporter=spec
  WORKING_DIRECTORY ${WORK} RESULT_VARIABLE failed)
if(failed)
  message(FATAL_ERROR "reports do not pass in the browser")
endif()
