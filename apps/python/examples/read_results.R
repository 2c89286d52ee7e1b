# Reads a track and a fit into R; the package jsonlite (Debian: r-cran-jsonlite) reads the fit.
# Use: Rscript read_results.R track.csv fit.json
arguments <- commandArgs(trailingOnly = TRUE)

track <- read.csv(arguments[1])  # empty cells become NA
ok <- track$status == "ok"
cat(sprintf("%d frames, %d ok, x from %.3f to %.3f px\n", nrow(track), sum(ok), min(track$x_px[ok]), max(track$x_px[ok])))

fit <- jsonlite::fromJSON(arguments[2])
mu1 <- fit$parameters$mu1
cat(sprintf("mu1 = %.7f, sd %.7f\n", mu1$estimate, mu1$sd))
