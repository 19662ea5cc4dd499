# cmake -DSOURCE_DIR=... -DOUTPUT=... -P git_revision.cmake: writes a header with the revision of SOURCE_DIR.
set(revision "unknown")
find_program(git git)
if(git)
  # A non-empty prefix means that the sources lie inside somebody else's checkout.
  execute_process(COMMAND ${git} -C ${SOURCE_DIR} rev-parse --show-prefix
    OUTPUT_VARIABLE prefix RESULT_VARIABLE failed ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
  if(NOT failed AND prefix STREQUAL "")
    execute_process(COMMAND ${git} -C ${SOURCE_DIR} rev-parse --short=8 HEAD
      OUTPUT_VARIABLE head RESULT_VARIABLE failed ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
    if(NOT failed)
      # Documents are no sources: scripts/reproduce.sh writes some, and goes on after it was killed.
      execute_process(COMMAND ${git} --no-optional-locks -C ${SOURCE_DIR} status --porcelain --untracked-files=no
        -- . ":(exclude)docs" ":(exclude)*.md"
        OUTPUT_VARIABLE changes ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
      set(revision ${head})
      if(changes)
        string(APPEND revision "-dirty")
      endif()
    endif()
  endif()
endif()

set(content "#pragma once\n#define DIFFSAC_GIT_REVISION \"${revision}\"\n")
set(old "")
if(EXISTS ${OUTPUT})
  file(READ ${OUTPUT} old)
endif()
if(NOT content STREQUAL old)
  file(WRITE ${OUTPUT} "${content}")
endif()
