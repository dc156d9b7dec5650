# conddp_options: the flags of every target of this project.
add_library(conddp_options INTERFACE)

# Left out: a warning that contradicts designated initialisers, and those of g++'s optimiser that are
# wrong about the standard library's strings and about its own AVX-512 intrinsics in version 12; the
# sanitizers look for the real ones.
target_compile_options(conddp_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wno-psabi
  -Wno-missing-field-initializers
  "$<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized;-Wno-restrict;-Wno-stringop-overflow>"
  "$<$<CXX_COMPILER_ID:GNU>:-Wno-array-bounds>"
  -fno-math-errno -ffp-contract=fast
  $<$<BOOL:${CONDDP_WERROR}>:-Werror>
  $<$<BOOL:${CONDDP_MARCH}>:-march=${CONDDP_MARCH}>
  $<$<AND:$<BOOL:${CONDDP_PCH}>,$<CXX_COMPILER_ID:GNU>>:-fpch-preprocess>)

target_compile_definitions(conddp_options INTERFACE
  $<$<CONFIG:Debug,Sanitize>:_GLIBCXX_ASSERTIONS>)

# The build type of the preset "sanitize": like RelWithDebInfo, with assertions.
set(CMAKE_CXX_FLAGS_SANITIZE "-O1 -g1 -fno-omit-frame-pointer" CACHE STRING
  "Flags of the build type Sanitize")
mark_as_advanced(CMAKE_CXX_FLAGS_SANITIZE)

if(CONDDP_SANITIZE)
  set(sanitizers -fsanitize=address,undefined -fno-sanitize-recover=all)
  target_compile_options(conddp_options INTERFACE ${sanitizers})
  target_link_options(conddp_options INTERFACE ${sanitizers})
endif()
