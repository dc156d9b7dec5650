# conddp_vector_bytes(RESULT FLAG...): the bytes of the widest vector registers that the C++ compiler
# uses with CMAKE_CXX_FLAGS and these flags: 64 with AVX-512, 32 with AVX, else 16. On it depend the
# width of conddp's Lane, how it is passed to functions, and how Eigen aligns its storage.
function(conddp_vector_bytes result)
  separate_arguments(flags UNIX_COMMAND "${CMAKE_CXX_FLAGS}")
  execute_process(
    COMMAND ${CMAKE_CXX_COMPILER} ${flags} ${ARGN} -dM -E -x c++ /dev/null
    OUTPUT_VARIABLE macros ERROR_VARIABLE errors RESULT_VARIABLE failed)
  if(failed)
    message(FATAL_ERROR "${CMAKE_CXX_COMPILER} does not preprocess with ${flags} ${ARGN}:\n${errors}")
  endif()
  if(macros MATCHES "#define __AVX512F__ ")
    set(bytes 64)
  elseif(macros MATCHES "#define __AVX__ ")
    set(bytes 32)
  else()
    set(bytes 16)
  endif()
  set(${result} ${bytes} PARENT_SCOPE)
endfunction()
