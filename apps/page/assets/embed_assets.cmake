# tribotrack_embed_assets(target): carries the files of pages (apps/page/assets), the script that draws figures for print and
# the plotting library inside target, which then defines apps/page/assets/embedded_assets.h. The source tree is never
# written to.
include("${CMAKE_CURRENT_LIST_DIR}/fetch_libraries.cmake")

function(tribotrack_embed_assets target)
  set(web "${CMAKE_CURRENT_FUNCTION_LIST_DIR}")
  tribotrack_fetch_plotly(TRIBOTRACK_ASSET_PLOTLY_JS)
  set(TRIBOTRACK_ASSET_PAGE_TEMPLATE "${web}/page.html")
  set(TRIBOTRACK_ASSET_PAGE_CSS "${web}/page.css")
  set(TRIBOTRACK_ASSET_PAGE_JS "${web}/page.js")
  set(TRIBOTRACK_ASSET_FIGURES_JS "${web}/figures.js")
  set(TRIBOTRACK_ASSET_FIGURES_PY "${web}/figures.py")
  set(generated "${CMAKE_CURRENT_BINARY_DIR}/embedded_assets.cpp")
  configure_file("${CMAKE_CURRENT_FUNCTION_LIST_DIR}/embedded_assets.cpp.in" "${generated}" @ONLY)
  # The compiler does not report what the assembler reads.
  set_source_files_properties("${generated}" PROPERTIES OBJECT_DEPENDS
    "${TRIBOTRACK_ASSET_PLOTLY_JS};${TRIBOTRACK_ASSET_PAGE_TEMPLATE};${TRIBOTRACK_ASSET_PAGE_CSS};${TRIBOTRACK_ASSET_PAGE_JS};${TRIBOTRACK_ASSET_FIGURES_JS};${TRIBOTRACK_ASSET_FIGURES_PY}")
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${web}/package-lock.json")
  target_sources(${target} PRIVATE "${generated}")
endfunction()
