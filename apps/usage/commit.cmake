# Writes OUTPUT, which defines source_commit(); leaves it alone where it says the same already, so that nothing is compiled anew.
# Use: cmake -DSOURCE=... -DOUTPUT=... -P commit.cmake
set(commit "")
find_program(git git)
if(git AND EXISTS "${SOURCE}/.git")
  execute_process(COMMAND "${git}" -C "${SOURCE}" rev-parse --short=10 HEAD OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE
    ERROR_QUIET)
  execute_process(COMMAND "${git}" -C "${SOURCE}" diff --quiet HEAD -- RESULT_VARIABLE changed OUTPUT_QUIET ERROR_QUIET)
  if(commit AND changed)
    string(APPEND commit "+")
  endif()
endif()
set(text "#include \"apps/usage/commit.h\"\n\nconst char* tribotrack::apps::source_commit() {\n  return \"${commit}\";\n}\n")
if(EXISTS "${OUTPUT}")
  file(READ "${OUTPUT}" before)
endif()
if(NOT "${before}" STREQUAL "${text}")
  file(WRITE "${OUTPUT}" "${text}")
endif()
