# Run by cpack on the installed files before they become a package: copyright, changelogs, completion and manual pages from
# --help, and the permissions of folders.
set(root "${CPACK_TEMPORARY_INSTALL_DIRECTORY}/usr/share")
set(documents "${root}/doc/${CPACK_PACKAGE_NAME}")
file(MAKE_DIRECTORY "${documents}")

# In Debian's form: a text's lines are indented by one space, an empty one is a dot.
function(indented result file)
  file(READ "${file}" text)
  string(STRIP "${text}" text)
  string(REGEX REPLACE "\n\n" "\n.\n" text "${text}")
  string(REGEX REPLACE "\n" "\n " text " ${text}")
  set(${result} "${text}" PARENT_SCOPE)
endfunction()
indented(license "${CPACK_TRIBOTRACK_SOURCE}/LICENSE")
configure_file("${CMAKE_CURRENT_LIST_DIR}/copyright.in" "${documents}/copyright" @ONLY NEWLINE_STYLE UNIX)

string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)  # SOURCE_DATE_EPOCH where it is set
file(WRITE "${documents}/changelog.Debian"
  "${CPACK_PACKAGE_NAME} (${CPACK_PACKAGE_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE}) unstable; urgency=medium\n\n"
  "  * Packaged by the project; changelog.gz tells what changed.\n\n"
  " -- ${CPACK_DEBIAN_PACKAGE_MAINTAINER}  ${date}\n")
configure_file("${CPACK_TRIBOTRACK_SOURCE}/CHANGELOG.md" "${documents}/changelog" COPYONLY)

set(program "${CPACK_TEMPORARY_INSTALL_DIRECTORY}/usr/bin/tribotrack")
file(MAKE_DIRECTORY "${root}/bash-completion/completions")
execute_process(COMMAND "${CMAKE_CURRENT_LIST_DIR}/bash_completion.sh" "${program}"
  OUTPUT_FILE "${root}/bash-completion/completions/tribotrack" COMMAND_ERROR_IS_FATAL ANY)
find_program(help2man help2man)
if(help2man)
  execute_process(COMMAND "${CMAKE_CURRENT_LIST_DIR}/manual_pages.sh" "${program}" "${CPACK_PACKAGE_VERSION}" "${root}/man/man1"
    COMMAND_ERROR_IS_FATAL ANY)
else()
  message(WARNING "help2man is not installed: the package has no manual pages")
endif()

file(GLOB_RECURSE pages "${root}/man/*.[1-9]")
execute_process(COMMAND gzip -9nf ${pages} "${documents}/changelog" "${documents}/changelog.Debian" COMMAND_ERROR_IS_FATAL ANY)
file(GLOB compressed "${documents}/*")
list(FILTER compressed EXCLUDE REGEX "/(examples?|manual)$")
list(TRANSFORM pages APPEND .gz)
file(CHMOD ${compressed} ${pages} FILE_PERMISSIONS OWNER_READ OWNER_WRITE GROUP_READ WORLD_READ)
# Whatever the umask of whoever packs.
file(CHMOD_RECURSE "${CPACK_TEMPORARY_INSTALL_DIRECTORY}/usr" DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
