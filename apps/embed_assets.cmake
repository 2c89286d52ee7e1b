function(tribotrack_embed_assets target)
endfunction()
