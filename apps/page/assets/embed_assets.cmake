# tribotrack_embed_assets(target): carries the files of pages (apps/page/assets), the script that draws figures for print, the workflow (apps/workflow), the
# plotting library and the conditions of the paper's figures (data/figure*.toml) inside target, which then defines apps/page/assets/embedded_assets.h. The source tree is never
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
  set(TRIBOTRACK_ASSET_FRAMES_TEMPLATE "${web}/frames.html")
  set(TRIBOTRACK_ASSET_FRAMES_JS "${web}/frames.js")
  set(TRIBOTRACK_ASSET_SNAKEFILE "${PROJECT_SOURCE_DIR}/apps/workflow/Snakefile")
  set(TRIBOTRACK_ASSET_SLURM_PROFILE "${PROJECT_SOURCE_DIR}/apps/workflow/slurm.yaml")
  set(TRIBOTRACK_ASSET_SLURM_STATUS "${PROJECT_SOURCE_DIR}/apps/workflow/slurm_status.sh")
  file(GLOB scenarios CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/data/figure*.toml")
  set(TRIBOTRACK_EMBED_SCENARIOS "")
  set(TRIBOTRACK_VIEW_SCENARIOS "")
  foreach(file IN LISTS scenarios)
    get_filename_component(name "${file}" NAME_WE)
    string(APPEND TRIBOTRACK_EMBED_SCENARIOS "TRIBOTRACK_EMBED(${name}, \"${file}\")\n")
    string(APPEND TRIBOTRACK_VIEW_SCENARIOS "{\"${name}\", TRIBOTRACK_VIEW(${name})}, ")
  endforeach()
  set(generated "${CMAKE_CURRENT_BINARY_DIR}/embedded_assets.cpp")
  configure_file("${CMAKE_CURRENT_FUNCTION_LIST_DIR}/embedded_assets.cpp.in" "${generated}" @ONLY)
  # The compiler does not report what the assembler reads.
  set_source_files_properties("${generated}" PROPERTIES OBJECT_DEPENDS
    "${TRIBOTRACK_ASSET_PLOTLY_JS};${TRIBOTRACK_ASSET_PAGE_TEMPLATE};${TRIBOTRACK_ASSET_PAGE_CSS};${TRIBOTRACK_ASSET_PAGE_JS};${TRIBOTRACK_ASSET_FIGURES_JS};${TRIBOTRACK_ASSET_FIGURES_PY};${TRIBOTRACK_ASSET_FRAMES_TEMPLATE};${TRIBOTRACK_ASSET_FRAMES_JS};${TRIBOTRACK_ASSET_SNAKEFILE};${TRIBOTRACK_ASSET_SLURM_PROFILE};${TRIBOTRACK_ASSET_SLURM_STATUS};${scenarios}")
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${web}/package-lock.json")
  target_sources(${target} PRIVATE "${generated}")
endfunction()
