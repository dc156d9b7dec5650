# conddp_abi: what all code that shares this library's types has to be compiled with, the programs of
# library users included. Lanes are as wide as the vector registers and Eigen aligns its storage to
# them, so objects of other widths must not meet; a sanitized library needs its run-time.
include(cmake/vector_bytes.cmake)
include(CheckCXXCompilerFlag)
set(CONDDP_ABI_OPTIONS "")
if(CONDDP_MARCH)
  list(APPEND CONDDP_ABI_OPTIONS -march=${CONDDP_MARCH})
endif()
conddp_vector_bytes(CONDDP_VECTOR_BYTES ${CONDDP_ABI_OPTIONS})
if(CONDDP_SANITIZE OR CONDDP_FUZZ)
  list(APPEND CONDDP_ABI_OPTIONS -fsanitize=address,undefined -fno-sanitize-recover=all)
endif()
if(CONDDP_FUZZ)
  list(APPEND CONDDP_ABI_OPTIONS -fsanitize=fuzzer-no-link)
endif()
add_library(conddp_abi INTERFACE)
set_target_properties(conddp_abi PROPERTIES EXPORT_NAME abi)
target_compile_features(conddp_abi INTERFACE cxx_std_20)
target_compile_options(conddp_abi INTERFACE ${CONDDP_ABI_OPTIONS})
if(CONDDP_SANITIZE OR CONDDP_FUZZ)
  target_link_options(conddp_abi INTERFACE ${CONDDP_ABI_OPTIONS})
endif()

# conddp_options: the flags of every target of this project.
add_library(conddp_options INTERFACE)
target_link_libraries(conddp_options INTERFACE conddp_abi)

# Left out: a warning that contradicts designated initialisers, and those of g++'s optimiser that are
# wrong about the standard library's strings and about its own AVX-512 intrinsics in version 12; the
# sanitizers look for the real ones. Code that sanitizers instrument brings further wrong ones, for which
# g++'s manual advises against -Werror with them: there warnings stay warnings.
target_compile_options(conddp_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wno-psabi
  -Wno-missing-field-initializers
  "$<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized;-Wno-restrict;-Wno-stringop-overflow>"
  "$<$<CXX_COMPILER_ID:GNU>:-Wno-array-bounds>"
  "$<$<AND:$<CXX_COMPILER_ID:GNU>,$<CONFIG:Sanitize>>:-Wno-uninitialized>"
  -fno-math-errno -ffp-contract=fast
  $<$<AND:$<BOOL:${CONDDP_WERROR}>,$<NOT:$<CONFIG:Sanitize>>>:-Werror>
  $<$<AND:$<BOOL:${CONDDP_PCH}>,$<CXX_COMPILER_ID:GNU>>:-fpch-preprocess>)

# conddp_cold_options: flags of code that reads, writes and tests. It spends its time in libraries and in
# the numerical layers, and compiles in three quarters of the time of -O3. g++ takes the level from the
# precompiled header of a source, so that both need these options. At this level g++ 12 calls its own
# AVX-512 intrinsics uninitialized.
add_library(conddp_cold_options INTERFACE)
target_compile_options(conddp_cold_options INTERFACE
  $<$<CONFIG:Release>:-O1> $<$<AND:$<CXX_COMPILER_ID:GNU>,$<CONFIG:Release>>:-Wno-uninitialized>)

# Functions of a shared library may be replaced at run time, and are therefore not inlined. None of the
# Python module's is.
if(CONDDP_PYTHON)
  target_compile_options(conddp_options INTERFACE
    $<$<BOOL:$<TARGET_PROPERTY:POSITION_INDEPENDENT_CODE>>:-fno-semantic-interposition>)
endif()

# What the optimiser warns of depends on what it has inlined and how it has vectorised, hence on the
# processor, and g++ 12 says it of its own headers (_mm512_shuffle_f64x2: its bug 105593). Whether a
# tree is good must not depend on either: such warnings are never errors.
if(CONDDP_WERROR AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  foreach(warning uninitialized aggressive-loop-optimizations dangling-pointer free-nonheap-object
      nonnull null-dereference overflow stringop-overread stringop-truncation use-after-free)
    check_cxx_compiler_flag(-Wno-error=${warning} CONDDP_KNOWS_WARNING_${warning})
    if(CONDDP_KNOWS_WARNING_${warning})
      target_compile_options(conddp_options INTERFACE -Wno-error=${warning})
    endif()
  endforeach()
endif()

target_compile_definitions(conddp_options INTERFACE
  $<$<CONFIG:Debug,Sanitize>:_GLIBCXX_ASSERTIONS>)

# The build type of the preset "sanitize". project() has put an empty string for it into the cache, which
# another set() would leave there. -Og because the sanitizers' checks are most of the code: it compiles
# no slower than -O0 and in half the time of -O1.
if(NOT CMAKE_CXX_FLAGS_SANITIZE)
  set(CMAKE_CXX_FLAGS_SANITIZE "-Og -fno-omit-frame-pointer" CACHE STRING
    "Flags of the build type Sanitize" FORCE)
endif()
mark_as_advanced(CMAKE_CXX_FLAGS_SANITIZE)
