# The second path of a tool that serves several kinds of processor: with CONDDP_WIDER_MARCH the tool is
# built once more, for that -march, and lies beside `conddp` as `conddp-<instruction set>`. When conddp
# starts on a processor that has the instructions, it becomes that one (apps/conddp/processor_check.cpp).
# Lanes have the width of the vector registers and are part of most types, so that the two paths share
# no object; as programs of their own they cannot be mixed up by the linker.
include(ExternalProject)
include(${PROJECT_SOURCE_DIR}/cmake/processor_features.cmake)

conddp_processor_features(wider_features -march=${CONDDP_WIDER_MARCH})
if(NOT wider_features)
  message(FATAL_ERROR "CONDDP_WIDER_MARCH=${CONDDP_WIDER_MARCH}: only x86-64 has a second path")
endif()
conddp_instruction_set(wider_set "${wider_features}")
set(wider_tool ${CMAKE_RUNTIME_OUTPUT_DIRECTORY}/conddp-${wider_set})
conddp_vector_bytes(wider_bytes -march=${CONDDP_WIDER_MARCH})
set(wider_module conddp-ipopt-${wider_bytes}${CMAKE_SHARED_MODULE_SUFFIX})

ExternalProject_Add(conddp_wider
  SOURCE_DIR ${PROJECT_SOURCE_DIR}
  BINARY_DIR ${PROJECT_BINARY_DIR}/wider
  PREFIX ${PROJECT_BINARY_DIR}/wider-steps
  CMAKE_ARGS
    -D CMAKE_BUILD_TYPE=${CMAKE_BUILD_TYPE}
    -D CMAKE_CXX_COMPILER=${CMAKE_CXX_COMPILER}
    -D CMAKE_CXX_FLAGS=${CMAKE_CXX_FLAGS}
    -D CMAKE_PREFIX_PATH=${CMAKE_PREFIX_PATH}
    -D CONDDP_WERROR=${CONDDP_WERROR}
    -D CONDDP_MARCH=${CONDDP_WIDER_MARCH}
    -D CONDDP_WIDER_MARCH=
    -D CMAKE_INSTALL_PREFIX=${CMAKE_INSTALL_PREFIX}
    -D CMAKE_INSTALL_BINDIR=${CMAKE_INSTALL_BINDIR}
    -D CMAKE_INSTALL_LIBDIR=${CMAKE_INSTALL_LIBDIR}
    -D BUILD_TESTING=OFF
  BUILD_COMMAND ${CMAKE_COMMAND} --build <BINARY_DIR> --target conddp
  BUILD_ALWAYS ON
  INSTALL_COMMAND ${CMAKE_COMMAND} -E copy_if_different <BINARY_DIR>/bin/conddp ${wider_tool}
  COMMAND ${CMAKE_COMMAND} -E copy_if_different
    <BINARY_DIR>/bin/${CONDDP_MODULES_FROM_TOOL}/${wider_module} ${CONDDP_MODULE_DIR}/${wider_module}
  USES_TERMINAL_BUILD ON)
add_dependencies(conddp conddp_wider)

install(PROGRAMS ${wider_tool} DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT tool)
install(FILES ${CONDDP_MODULE_DIR}/${wider_module}
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/conddp COMPONENT tool)
# `cmake --install --strip` and CPack strip targets only.
install(CODE "
  if(CMAKE_INSTALL_DO_STRIP)
    set(prefix \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}\")
    execute_process(COMMAND ${CMAKE_STRIP} \"\${prefix}/${CMAKE_INSTALL_BINDIR}/conddp-${wider_set}\"
      \"\${prefix}/${CMAKE_INSTALL_LIBDIR}/conddp/${wider_module}\")
  endif()"
  COMPONENT tool)
