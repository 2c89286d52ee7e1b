% Reads a track and a fit into GNU Octave (or MATLAB): read_results(TRACK_CSV, FIT_JSON)
% Use: octave --no-gui --quiet read_results.m track.csv fit.json
1;

function read_results(track_csv, fit_json)
  % The columns by name; empty cells are NaN.
  lines = strsplit(strtrim(fileread(track_csv)), "\n");
  names = strsplit(lines{1}, ",");
  track = struct();
  cells = cellfun(@(line) strsplit(line, ",", "CollapseDelimiters", false), lines(2:end), "UniformOutput", false);
  cells = vertcat(cells{:});
  for k = 1:numel(names)
    if strcmp(names{k}, "status")
      track.status = cells(:, k);
    else
      track.(names{k}) = str2double(cells(:, k));
    end
  end
  ok = strcmp(track.status, "ok");
  printf("%d frames, %d ok, x from %.3f to %.3f px\n", numel(ok), sum(ok), min(track.x_px(ok)), max(track.x_px(ok)));

  fit = jsondecode(fileread(fit_json));
  mu1 = fit.parameters.mu1;
  printf("mu1 = %.7f, sd %.7f\n", mu1.estimate, mu1.sd);
end

given = argv();
if numel(given) >= 2
  read_results(given{end - 1}, given{end});
end
