# cmake -D GIT= -D SOURCE_DIR= -D INPUT= -D OUTPUT= -P write_revision.cmake
# Fills the git revision into the version source; the file is touched only when it changes.
set(CONDDP_REVISION unknown)
set(CONDDP_DIRTY false)
if(GIT)
  execute_process(COMMAND ${GIT} -C ${SOURCE_DIR} rev-parse --short=12 HEAD
    OUTPUT_VARIABLE head OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
  if(NOT failed)
    set(CONDDP_REVISION ${head})
    execute_process(COMMAND ${GIT} -C ${SOURCE_DIR} status --porcelain --untracked-files=no
      OUTPUT_VARIABLE changes ERROR_QUIET)
    if(changes)
      set(CONDDP_DIRTY true)
    endif()
  endif()
endif()
configure_file(${INPUT} ${OUTPUT} @ONLY)
