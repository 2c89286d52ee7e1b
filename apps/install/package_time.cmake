# Run by cpack before it packs. Files, archives and the changelog carry SOURCE_DATE_EPOCH; where the environment has none, the
# time of the source's last commit, so that the same source gives the same package on every day.
if(NOT DEFINED ENV{SOURCE_DATE_EPOCH})
  execute_process(COMMAND git -C "${CPACK_TRIBOTRACK_SOURCE}" log -1 --format=%ct OUTPUT_VARIABLE time
    OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
  if(NOT failed)
    set(ENV{SOURCE_DATE_EPOCH} "${time}")
  else()
    message(WARNING "git tells no commit of ${CPACK_TRIBOTRACK_SOURCE}: the files of this package carry the time of the build, and "
      "who builds it again gets other bytes. Install git and build in a clone, or set SOURCE_DATE_EPOCH.")
  endif()
endif()
