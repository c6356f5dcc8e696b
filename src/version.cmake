# Writes the git commit of the source tree to a header, at every build; the header changes only when the
# commit does, so that nothing is compiled again without need.
# Arguments: SOURCE_DIR, OUTPUT
set(commit "unknown")
find_program(git git)
if(git)
  # The tree may belong to another user than the one who builds it.
  set(git_command ${git} -c safe.directory=* -C ${SOURCE_DIR})
  execute_process(COMMAND ${git_command} rev-parse --show-toplevel
                  OUTPUT_VARIABLE top OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  file(REAL_PATH "${SOURCE_DIR}" source_path)
  # A source archive unpacked inside some other repository has no commit of its own.
  if(top STREQUAL source_path)
    execute_process(COMMAND ${git_command} rev-parse --verify --quiet HEAD
                    OUTPUT_VARIABLE head OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET
                    RESULT_VARIABLE status)
    if(status EQUAL 0)
      execute_process(COMMAND ${git_command} status --porcelain --untracked-files=no
                      OUTPUT_VARIABLE changes ERROR_QUIET)
      set(commit "${head}")
      if(NOT changes STREQUAL "")
        string(APPEND commit "-dirty")
      endif()
    endif()
  endif()
endif()
# A source bundle says what it was made of.
if(commit STREQUAL "unknown" AND EXISTS ${SOURCE_DIR}/external/commit)
  file(STRINGS ${SOURCE_DIR}/external/commit commit LIMIT_COUNT 1)
endif()
set(text "#pragma once\n#define CRACKLE_GIT_COMMIT \"${commit}\"\n")
set(old "")
if(EXISTS ${OUTPUT})
  file(READ ${OUTPUT} old)
endif()
if(NOT old STREQUAL text)
  file(WRITE ${OUTPUT} "${text}")
endif()
