# cmake -D BUILD_DIR= -D EXAMPLE_DIR= -D CXX= -D EIGEN_INCLUDE_DIR= -D PROCESSOR= -D WORK_DIR=
#   -P installed_example.cmake
# Installs the library into a separate prefix, then builds and runs the examples like a library user,
# with only that prefix. Also compiles a header without the flags of the package.
function(run what)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE failed OUTPUT_VARIABLE output ERROR_VARIABLE errors)
  if(failed)
    message(FATAL_ERROR "${what} failed (${failed}):\n${output}\n${errors}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

function(expect_in text wanted)
  string(FIND "${text}" "${wanted}" at)
  if(at EQUAL -1)
    message(FATAL_ERROR "expected '${wanted}' in:\n${text}")
  endif()
endfunction()

file(REMOVE_RECURSE ${WORK_DIR})
set(prefix ${WORK_DIR}/prefix)
run("installing" ${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${prefix} --component library)

# A moved package still works: nothing in it may contain its install path.
file(RENAME ${prefix} ${WORK_DIR}/moved)
set(prefix ${WORK_DIR}/moved)

run("configuring the example" ${CMAKE_COMMAND} -S ${EXAMPLE_DIR} -B ${WORK_DIR}/example -G Ninja
  -D CMAKE_CXX_COMPILER=${CXX} -D CMAKE_PREFIX_PATH=${prefix})
run("building the example" ${CMAKE_COMMAND} --build ${WORK_DIR}/example)
run("running the example" ${WORK_DIR}/example/lift)
message("${output}")
expect_in("${output}" "converged after")
expect_in("${output}" "largest torque 6.000 Nm")

# Few and many solves must cause the same number of allocations.
run("building the counter" ${CXX} -std=c++20 -O2 -shared -fPIC -o ${WORK_DIR}/count_allocations.so
  ${CMAKE_CURRENT_LIST_DIR}/count_allocations.cpp)
function(expect_same_allocations example few many)
  foreach(solves IN ITEMS ${few} ${many})
    execute_process(
      COMMAND ${CMAKE_COMMAND} -E env LD_PRELOAD=${WORK_DIR}/count_allocations.so
        ${WORK_DIR}/example/${example} ${solves}
      RESULT_VARIABLE failed OUTPUT_QUIET ERROR_VARIABLE errors)
    # `cmake -E env` inherits the environment too; its count is printed last.
    if(failed OR NOT errors MATCHES "^allocations: ([0-9]+)")
      message(FATAL_ERROR "counting the allocations of ${example} failed (${failed}): ${errors}")
    endif()
    list(APPEND allocations ${CMAKE_MATCH_1})
  endforeach()
  list(GET allocations 0 of_few)
  list(GET allocations 1 of_many)
  if(NOT of_few GREATER 100 OR NOT of_many EQUAL of_few)
    message(FATAL_ERROR "${example}: ${few} solves allocate ${of_few} times, ${many} solves ${of_many} times")
  endif()
endfunction()

run("running the loop of solves" ${WORK_DIR}/example/crane)
message("${output}")
expect_in("${output}" "solve 9:")
expect_same_allocations(crane 1 10)
run("running the closed loop" ${WORK_DIR}/example/balance)
message("${output}")
expect_in("${output}" "ends 0.00")
expect_same_allocations(balance 20 150)

# From an empty folder, the tool finds the examples installed with it.
run("installing the tool" ${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${prefix}/tool
  --component tool)
file(RENAME ${prefix}/tool ${prefix}/moved_tool)
file(MAKE_DIRECTORY ${WORK_DIR}/empty)
run("listing the examples" ${CMAKE_COMMAND} -E chdir ${WORK_DIR}/empty
  ${prefix}/moved_tool/bin/conddp list problems)
expect_in("${output}" "moved_tool/share/conddp/problems/arm_reach.yaml")
run("solving an example" ${CMAKE_COMMAND} -E chdir ${WORK_DIR}/empty
  ${prefix}/moved_tool/bin/conddp solve arm_reach)
expect_in("${output}" "arm_reach: converged")
# The Ipopt library is installed with the tool.
run("solving an example by ipopt" ${CMAKE_COMMAND} -E chdir ${WORK_DIR}/empty
  ${prefix}/moved_tool/bin/conddp solve double_integrator_fastest)
expect_in("${output}" "double_integrator_fastest: converged (ipopt")
run("comparing solvers on the examples" ${CMAKE_COMMAND} -E chdir ${WORK_DIR}/empty
  ${prefix}/moved_tool/bin/conddp bench --solvers intro --repeat 0 --max-time 0.001)
expect_in("${output}" "all problems")
run("comparing with the best known optimum" ${CMAKE_COMMAND} -E chdir ${WORK_DIR}/empty
  ${prefix}/moved_tool/bin/conddp bench pendulum_swingup --solvers box_ddp --repeat 0 --json)
expect_in("${output}" "\"best_known\": 0.0184046")

# The component for problem files finds its dependencies.
file(WRITE ${WORK_DIR}/files/CMakeLists.txt "
cmake_minimum_required(VERSION 3.22)
project(files LANGUAGES CXX)
find_package(conddp REQUIRED COMPONENTS files)
add_executable(files main.cpp)
target_link_libraries(files PRIVATE conddp::files)
")
file(WRITE ${WORK_DIR}/files/main.cpp "
#include \"conddp/files.hpp\"
#include <cstdio>
int main(int, char** argv) {
  conddp::Diagnostics messages;
  const auto built =
      conddp::build_problem(conddp::read_problem(argv[1], {}, messages), {}, messages);
  std::fputs(conddp::format_diagnostics(messages, false).c_str(), stderr);
  if (!built) return 2;
  const conddp::SolverInfo* solver = nullptr;
  const auto candidates = conddp::usable_solvers(*built, messages);
  const conddp::SolveResult result = conddp::solve(
      *built->problem, candidates, built->facts().solver.options, built->guess, solver);
  const conddp::Solution solution{*built, *solver, result, {}};
  for (const auto& file :
       conddp::write_solution(solution, conddp::solution_json(solution), argv[2], {}))
    std::puts(file.c_str());
}
")
run("configuring with files" ${CMAKE_COMMAND} -S ${WORK_DIR}/files -B ${WORK_DIR}/files/build
  -G Ninja -D CMAKE_CXX_COMPILER=${CXX} -D CMAKE_PREFIX_PATH=${prefix})
run("building with files" ${CMAKE_COMMAND} --build ${WORK_DIR}/files/build)
run("running with files" ${WORK_DIR}/files/build/files
  ${prefix}/moved_tool/share/conddp/problems/pendulum_swingup.yaml ${WORK_DIR}/files/out)
expect_in("${output}" "files/out/solution.json")
run("running ipopt with files" ${WORK_DIR}/files/build/files
  ${prefix}/moved_tool/share/conddp/problems/double_integrator_fastest.yaml ${WORK_DIR}/files/ipopt)
expect_in("${output}" "files/ipopt/solution.json")

# On another machine, where the same flags mean other vector sizes, find_package reports it.
file(GLOB_RECURSE config ${prefix}/conddp-config.cmake)
file(READ ${config} text)
string(REGEX REPLACE "EQUAL [0-9]+" "EQUAL 8" text "${text}")
file(WRITE ${config} "${text}")
execute_process(COMMAND ${CMAKE_COMMAND} -S ${EXAMPLE_DIR} -B ${WORK_DIR}/elsewhere -G Ninja
  -D CMAKE_CXX_COMPILER=${CXX} -D CMAKE_PREFIX_PATH=${prefix}
  RESULT_VARIABLE failed OUTPUT_QUIET ERROR_VARIABLE errors)
if(NOT failed)
  message(FATAL_ERROR "a package for other vectors was accepted")
endif()
expect_in("${errors}" "build it on this")

# Flags that differ from the library's are an error in the first header, not a crash.
if(NOT PROCESSOR MATCHES "x86_64|AMD64")
  return()
endif()
set(refused 0)
foreach(march IN ITEMS x86-64 x86-64-v3 x86-64-v4)
  execute_process(
    COMMAND ${CXX} -std=c++20 -march=${march} -I ${prefix}/include -I ${EIGEN_INCLUDE_DIR}
      -fsyntax-only -x c++ ${prefix}/include/conddp/abi.hpp
    RESULT_VARIABLE failed ERROR_VARIABLE errors)
  if(failed)
    math(EXPR refused "${refused} + 1")
    expect_in("${errors}" "link conddp::conddp, which sets the flags")
  endif()
endforeach()
if(NOT refused EQUAL 2)
  message(FATAL_ERROR "${refused} of three sets of flags were refused, not two")
endif()
