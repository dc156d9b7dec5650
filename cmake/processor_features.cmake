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
