# tribotrack_fetch_library(result name file purpose): sets result to FILE of the npm package NAME as pinned by version and
# hash in package-lock.json; tribotrack_fetch_plotly(result): of the plotting library that pages embed. The archive is
# looked for in, in this order:
#   the build folder, from an earlier run;
#   the cache, ${XDG_CACHE_HOME:-~/.cache}/tribotrack, where it is left for other builds and for builds without network;
#   the npm registry of the environment: npm_config_registry, npm's own configuration, ~/.npmrc;
#   the public npm registry, whose address is read from Debian's package node-registry-url. That package, 4 kB, is
#   downloaded but not installed: Debian's npm would bring 357 other packages along.
# Every archive must have the pinned hash. TRIBOTRACK_PLOTLY_JS names a file to embed instead of all this.

set(TRIBOTRACK_PLOTLY_JS "" CACHE FILEPATH
  "plotly-cartesian.min.js to embed in pages; empty: fetched as pinned in apps/page/assets")
set(TRIBOTRACK_LIBRARY_LOCK "${CMAKE_CURRENT_LIST_DIR}/package-lock.json")  # another one in tests

# The lock file holds the hash in base 64; file(DOWNLOAD) and file(SHA512) want hexadecimal digits.
function(tribotrack_hex_of_base64 result text)
  set(alphabet "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/")
  string(REGEX REPLACE "=+$" "" text "${text}")
  string(LENGTH "${text}" length)
  set(hex "")
  set(bits 0)    # of the value below, not yet written
  set(value 0)
  math(EXPR last "${length} - 1")
  foreach(k RANGE ${last})
    string(SUBSTRING "${text}" ${k} 1 letter)
    string(FIND "${alphabet}" "${letter}" digit)
    math(EXPR value "${value} << 6 | ${digit}")
    math(EXPR bits "${bits} + 6")
    while(bits GREATER_EQUAL 4)
      math(EXPR bits "${bits} - 4")
      math(EXPR nibble "${value} >> ${bits} & 15")
      math(EXPR value "${value} & ((1 << ${bits}) - 1)")
      string(SUBSTRING "0123456789abcdef" ${nibble} 1 nibble)
      string(APPEND hex ${nibble})
    endwhile()
  endforeach()
  string(LENGTH "${hex}" length)
  math(EXPR length "${length} / 8 * 8")  # the last letter may carry spare bits
  string(SUBSTRING "${hex}" 0 ${length} hex)
  set(${result} "${hex}" PARENT_SCOPE)
endfunction()

# The addresses of npm registries, the most particular first; empty where none is known.
function(tribotrack_npm_registries result folder)
  set(found "$ENV{npm_config_registry}" "$ENV{NPM_CONFIG_REGISTRY}")
  if(TRIBOTRACK_NPM)
    execute_process(COMMAND "${TRIBOTRACK_NPM}" config get registry WORKING_DIRECTORY "${folder}"
      OUTPUT_VARIABLE address OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
    list(APPEND found "${address}")
  elseif(EXISTS "$ENV{HOME}/.npmrc")
    file(STRINGS "$ENV{HOME}/.npmrc" lines REGEX "^ *registry *=")
    list(TRANSFORM lines REPLACE "^ *registry *= *\"?([^\" ]*).*" "\\1")
    list(APPEND found ${lines})
  endif()
  if(NOT TRIBOTRACK_NPM)
    set(debian "/usr/share/nodejs/registry-url/index.js")
    if(NOT EXISTS "${debian}")
      find_program(TRIBOTRACK_APT_GET apt-get)
      find_program(TRIBOTRACK_DPKG_DEB dpkg-deb)
      mark_as_advanced(TRIBOTRACK_APT_GET TRIBOTRACK_DPKG_DEB)
      if(TRIBOTRACK_APT_GET AND TRIBOTRACK_DPKG_DEB)
        execute_process(COMMAND "${TRIBOTRACK_APT_GET}" download -q node-registry-url WORKING_DIRECTORY "${folder}"
          OUTPUT_QUIET ERROR_QUIET)
        file(GLOB package "${folder}/node-registry-url_*.deb")
        if(package)
          execute_process(COMMAND "${TRIBOTRACK_DPKG_DEB}" -x ${package} "${folder}/node-registry-url")
          set(debian "${folder}/node-registry-url${debian}")
        endif()
      endif()
    endif()
    if(EXISTS "${debian}")
      file(READ "${debian}" text)
      if(text MATCHES "registry: *['\"]([a-z]+://[^'\"]+)")
        list(APPEND found "${CMAKE_MATCH_1}")
      endif()
    endif()
  endif()
  list(FILTER found INCLUDE REGEX "^[a-z]+://")
  list(TRANSFORM found REPLACE "/+$" "")
  list(REMOVE_DUPLICATES found)
  set(${result} "${found}" PARENT_SCOPE)
endfunction()

# A file with other contents is noted.
function(tribotrack_has_hash answer file wanted notes_name)
  set(${answer} FALSE PARENT_SCOPE)
  if(EXISTS "${file}")
    file(SHA512 "${file}" hash)
    if(hash STREQUAL wanted)
      set(${answer} TRUE PARENT_SCOPE)
    else()
      set(${notes_name} "${${notes_name}}\n  ${file}: its contents do not have the pinned hash" PARENT_SCOPE)
    endif()
  endif()
endfunction()

# Fetches name-version.tgz into folder from the first registry that has it with the wanted hash.
function(tribotrack_download answer folder name version wanted notes_name)
  set(archive "${folder}/${name}-${version}.tgz")
  set(text "${${notes_name}}")
  set(ready FALSE)
  find_program(TRIBOTRACK_NPM npm)
  mark_as_advanced(TRIBOTRACK_NPM)
  tribotrack_npm_registries(registries "${folder}")
  if(NOT registries)
    string(APPEND text "\n  no registry: npm is not installed, and Debian's package node-registry-url cannot be downloaded")
  endif()
  foreach(registry IN LISTS registries)
    string(REGEX REPLACE "//[^/]*@" "//" shown "${registry}")  # without a password
    message(STATUS "Fetching ${name} from ${shown}")
    file(DOWNLOAD "${registry}/${name}/-/${name}-${version}.tgz" "${archive}" STATUS status
      TLS_VERIFY ON INACTIVITY_TIMEOUT 30 TIMEOUT 300)
    list(POP_FRONT status failed reason)
    if(failed)
      string(APPEND text "\n  ${shown}: ${reason}")
      file(REMOVE "${archive}")
    endif()
    tribotrack_has_hash(ready "${archive}" ${wanted} text)
    if(ready)
      break()
    endif()
  endforeach()
  if(NOT ready AND TRIBOTRACK_NPM)  # knows the passwords, certificates and proxies of registries
    execute_process(COMMAND "${TRIBOTRACK_NPM}" pack --silent "${name}@${version}" WORKING_DIRECTORY "${folder}"
      OUTPUT_QUIET ERROR_VARIABLE output)
    string(APPEND text "\n  npm pack ${name}@${version}: ${output}")
    tribotrack_has_hash(ready "${archive}" ${wanted} text)
  endif()
  set(${answer} ${ready} PARENT_SCOPE)
  set(${notes_name} "${text}" PARENT_SCOPE)
endfunction()

function(tribotrack_fetch_library result name file purpose)
  file(READ "${TRIBOTRACK_LIBRARY_LOCK}" lock)
  string(JSON version GET "${lock}" packages "node_modules/${name}" version)
  string(JSON integrity GET "${lock}" packages "node_modules/${name}" integrity)
  string(REGEX REPLACE "^sha512-" "" integrity "${integrity}")
  tribotrack_hex_of_base64(wanted "${integrity}")
  set(folder "${CMAKE_BINARY_DIR}/libraries/${name}")
  set(archive "${folder}/${name}-${version}.tgz")
  set(cache "$ENV{XDG_CACHE_HOME}")
  if(NOT cache AND NOT "$ENV{HOME}" STREQUAL "")
    set(cache "$ENV{HOME}/.cache")
  elseif(NOT cache)
    set(cache "${CMAKE_BINARY_DIR}/cache")
  endif()
  set(cache "${cache}/tribotrack")
  set(kept "${cache}/${name}-${version}.tgz")

  set(notes "")
  file(MAKE_DIRECTORY "${folder}")
  tribotrack_has_hash(ready "${archive}" ${wanted} notes)
  if(NOT ready)
    tribotrack_has_hash(ready "${kept}" ${wanted} notes)
    if(ready)
      file(COPY_FILE "${kept}" "${archive}")
    endif()
  endif()
  if(NOT ready)
    tribotrack_download(ready "${folder}" ${name} ${version} ${wanted} notes)
    if(NOT ready)
      message(FATAL_ERROR "${purpose} ${name} ${version}, which was not found. Tried:${notes}\n"
        "Any of these helps:\n"
        "  with network, on Debian: apt-get update, then configure again\n"
        "  with network: name a registry in the environment, npm_config_registry=ADDRESS\n"
        "  without: npm pack ${name}@${version} on another machine, and copy the archive to ${kept}")
    endif()
    # A cache that cannot be written is no fault. Renaming keeps another build from reading half a file.
    string(RANDOM LENGTH 8 part)
    execute_process(COMMAND "${CMAKE_COMMAND}" -E make_directory "${cache}" ERROR_QUIET)
    file(COPY_FILE "${archive}" "${kept}.${part}" RESULT failed)
    if(NOT failed)
      file(RENAME "${kept}.${part}" "${kept}")
    endif()
  endif()

  set(script "${folder}/package/${file}")
  if(NOT EXISTS "${script}" OR "${archive}" IS_NEWER_THAN "${script}")
    file(ARCHIVE_EXTRACT INPUT "${archive}" DESTINATION "${folder}" PATTERNS package/${file} TOUCH)
  endif()
  set(${result} "${script}" PARENT_SCOPE)
endfunction()

function(tribotrack_fetch_plotly result)
  set(script "${TRIBOTRACK_PLOTLY_JS}")
  if(script AND NOT EXISTS "${script}")
    message(FATAL_ERROR "TRIBOTRACK_PLOTLY_JS names ${script}, which does not exist.")
  elseif(NOT script)
    tribotrack_fetch_library(script plotly.js-cartesian-dist-min plotly-cartesian.min.js
      "Without -DTRIBOTRACK_PLOTLY_JS=FILE, FILE being plotly-cartesian.min.js, pages embed")
  endif()
  set(${result} "${script}" PARENT_SCOPE)
endfunction()
