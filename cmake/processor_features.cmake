# conddp_processor_features(RESULT FLAG...): X("name") for each instruction set beyond the first x86-64 that
# the C++ compiler uses with CMAKE_CXX_FLAGS and these flags, by the names of __builtin_cpu_supports.
# Empty on other processors.
function(conddp_processor_features result)
  separate_arguments(flags UNIX_COMMAND "${CMAKE_CXX_FLAGS}")
  execute_process(
    COMMAND ${CMAKE_CXX_COMPILER} ${flags} ${ARGN} -dM -E -x c++ /dev/null
    OUTPUT_VARIABLE macros ERROR_QUIET)
  set(features "")
  if(macros MATCHES "#define __x86_64__ ")
    foreach(feature sse3 ssse3 sse4.1 sse4.2 popcnt avx avx2 fma bmi bmi2
        avx512f avx512vl avx512bw avx512dq avx512cd avx512ifma avx512vbmi avx512vnni avx512bitalg)
      string(TOUPPER ${feature} macro)
      string(REPLACE "." "_" macro ${macro})
      if(macros MATCHES "#define __${macro}__ ")
        string(APPEND features "X(\"${feature}\")")
      endif()
    endforeach()
  endif()
  set(${result} ${features} PARENT_SCOPE)
endfunction()

# conddp_instruction_set(RESULT FEATURES): the name of the widest vector registers among these features,
# as the environment's CONDDP_INSTRUCTIONS takes it.
function(conddp_instruction_set result features)
  set(name sse2)
  foreach(feature avx avx2 avx512f)
    if(features MATCHES "\"${feature}\"")
      string(REPLACE "avx512f" "avx512" name ${feature})
    endif()
  endforeach()
  set(${result} ${name} PARENT_SCOPE)
endfunction()

# conddp_processor_definitions(RESULT MARCH WIDER_MARCH): what apps/conddp/processor_check.cpp has to be
# compiled with in a tool for the one beside one for the other, which may be empty. Empty where that
# file is not wanted.
function(conddp_processor_definitions result march wider_march)
  set(definitions "")
  set(flags "")
  if(march)
    set(flags -march=${march})
  endif()
  conddp_processor_features(features ${flags})
  if(features)
    conddp_instruction_set(name "${features}")
    list(APPEND definitions
      "CONDDP_PROCESSOR_FEATURES=${features}" "CONDDP_INSTRUCTION_SET=\"${name}\"")
    if(wider_march)
      conddp_processor_features(wider_features -march=${wider_march})
      conddp_instruction_set(wider_name "${wider_features}")
      list(APPEND definitions
        "CONDDP_WIDER_FEATURES=${wider_features}" "CONDDP_WIDER_SET=\"${wider_name}\"")
    endif()
  endif()
  set(${result} ${definitions} PARENT_SCOPE)
endfunction()
