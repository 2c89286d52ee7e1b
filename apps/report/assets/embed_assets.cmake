# tribotrack_embed_assets(target): carries the report page's files (apps/report/assets) and the plotting library inside
# target, which then defines apps/report/assets/embedded_assets.h.
#
# plotly.js is pinned by version and hash in apps/report/assets/package-lock.json. It is taken from, in this order:
# TRIBOTRACK_PLOTLY_JS if given; apps/report/assets/node_modules if somebody ran `npm ci` there; else npm fetches it into
# the build directory. The source tree is never written to.

set(TRIBOTRACK_PLOTLY_JS "" CACHE FILEPATH
  "plotly-cartesian.min.js to embed in the report page; empty: fetched by npm as pinned in apps/report/assets")

function(tribotrack_find_plotly result)
  set(file_in_modules "node_modules/plotly.js-cartesian-dist-min/plotly-cartesian.min.js")
  set(web "${CMAKE_CURRENT_FUNCTION_LIST_DIR}")
  if(TRIBOTRACK_PLOTLY_JS)
    if(NOT EXISTS "${TRIBOTRACK_PLOTLY_JS}")
      message(FATAL_ERROR "TRIBOTRACK_PLOTLY_JS names ${TRIBOTRACK_PLOTLY_JS}, which does not exist.")
    endif()
    set(${result} "${TRIBOTRACK_PLOTLY_JS}" PARENT_SCOPE)
    return()
  endif()
  if(EXISTS "${web}/${file_in_modules}")
    set(${result} "${web}/${file_in_modules}" PARENT_SCOPE)
    return()
  endif()

  # A copy for npm to work in, fetched again only when the lock file has changed.
  set(copy "${CMAKE_BINARY_DIR}/web")
  file(SHA256 "${web}/package-lock.json" wanted)
  set(fetched "")
  if(EXISTS "${copy}/fetched.sha256")
    file(READ "${copy}/fetched.sha256" fetched)
  endif()
  if(NOT EXISTS "${copy}/${file_in_modules}" OR NOT fetched STREQUAL wanted)
    find_program(TRIBOTRACK_NPM npm)
    if(NOT TRIBOTRACK_NPM)
      message(FATAL_ERROR "The report page embeds plotly.js, and npm, which fetches it, is not installed. "
        "Install it (Debian: apt-get install npm), or give the file with "
        "-DTRIBOTRACK_PLOTLY_JS=.../plotly-cartesian.min.js.")
    endif()
    message(STATUS "Fetching plotly.js for the report page with npm")
    file(MAKE_DIRECTORY "${copy}")
    file(COPY "${web}/package.json" "${web}/package-lock.json" "${web}/.npmrc" DESTINATION "${copy}")
    execute_process(
      COMMAND "${TRIBOTRACK_NPM}" ci --ignore-scripts --no-audit --no-fund
      WORKING_DIRECTORY "${copy}"
      RESULT_VARIABLE failed OUTPUT_VARIABLE output ERROR_VARIABLE output)
    if(failed OR NOT EXISTS "${copy}/${file_in_modules}")
      message(FATAL_ERROR "npm could not fetch plotly.js for the report page into ${copy}:\n${output}\n"
        "Check the network or npm's registry setting, or give the file with "
        "-DTRIBOTRACK_PLOTLY_JS=.../plotly-cartesian.min.js.")
    endif()
    file(WRITE "${copy}/fetched.sha256" "${wanted}")
  endif()
  set(${result} "${copy}/${file_in_modules}" PARENT_SCOPE)
endfunction()

function(tribotrack_embed_assets target)
  set(web "${CMAKE_CURRENT_FUNCTION_LIST_DIR}")
  tribotrack_find_plotly(TRIBOTRACK_ASSET_PLOTLY_JS)
  set(TRIBOTRACK_ASSET_PAGE_TEMPLATE "${web}/page.html")
  set(TRIBOTRACK_ASSET_REPORT_CSS "${web}/report.css")
  set(TRIBOTRACK_ASSET_REPORT_JS "${web}/report.js")
  set(generated "${CMAKE_CURRENT_BINARY_DIR}/embedded_assets.cpp")
  configure_file("${CMAKE_CURRENT_FUNCTION_LIST_DIR}/embedded_assets.cpp.in" "${generated}" @ONLY)
  # The compiler does not report what the assembler reads.
  set_source_files_properties("${generated}" PROPERTIES OBJECT_DEPENDS
    "${TRIBOTRACK_ASSET_PLOTLY_JS};${TRIBOTRACK_ASSET_PAGE_TEMPLATE};${TRIBOTRACK_ASSET_REPORT_CSS};${TRIBOTRACK_ASSET_REPORT_JS}")
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${web}/package-lock.json")
  target_sources(${target} PRIVATE "${generated}")
endfunction()
