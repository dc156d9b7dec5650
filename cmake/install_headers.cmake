# Run by `cmake --install` with SOURCE_DIR, GENERATED_DIR, STAGE_DIR and INCLUDE_DIR set.
# Installs the headers of all layers below INCLUDE_DIR/conddp. Their includes name the layer alone in
# the source tree; installed they say "conddp/layer/file.hpp", so that no folder of a user's project
# can come between, and the check of the compiler's flags goes first.
file(REMOVE_RECURSE ${STAGE_DIR})
file(GLOB_RECURSE headers RELATIVE ${SOURCE_DIR}/src ${SOURCE_DIR}/src/*.hpp)
list(FILTER headers EXCLUDE REGEX "^batch/")  # a part of the tool alone
set(layers ${headers})
list(TRANSFORM layers REPLACE "/.*" "")
list(REMOVE_DUPLICATES layers)
list(JOIN layers "|" layers)

function(conddp_stage_header from to)
  file(READ ${from} text)
  string(REGEX REPLACE "#include \"((${layers})/[^\"]*)\"" "#include \"conddp/\\1\"" text "${text}")
  string(REPLACE "#include \"conddp_version.hpp\"" "#include \"conddp/version.hpp\"" text "${text}")
  string(REPLACE "#pragma once\n" "#pragma once\n\n#include \"conddp/abi.hpp\"\n" text "${text}")
  file(WRITE ${STAGE_DIR}/conddp/${to} "${text}")
endfunction()

foreach(header IN LISTS headers)
  conddp_stage_header(${SOURCE_DIR}/src/${header} ${header})
endforeach()
conddp_stage_header(${SOURCE_DIR}/include/conddp/conddp.hpp conddp.hpp)
conddp_stage_header(${GENERATED_DIR}/include/conddp_version.hpp version.hpp)
file(COPY ${GENERATED_DIR}/abi.hpp DESTINATION ${STAGE_DIR}/conddp)
file(INSTALL ${STAGE_DIR}/conddp TYPE DIRECTORY DESTINATION ${INCLUDE_DIR})
