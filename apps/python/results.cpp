// measure() and fit(): from tracks to parameters.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include <memory>
#include <utility>

#include "apps/campaign/fit_stage.h"
#include "apps/files/campaign/campaign.h"
#include "apps/files/track_file.h"
#include "apps/files/tracks/any_track.h"
#include "apps/fitting/fit_campaign.h"
#include "apps/measuring/measure_track.h"
#include "apps/program/context.h"
#include "apps/program/errors.h"
#include "apps/python/doors.h"
#include "apps/python/errors.h"
#include "apps/python/released.h"
#include "apps/python/tables.h"
#include "apps/python/values.h"

namespace tribotrack::python {

namespace py = pybind11;
using apps::UsageError;

namespace {

bool is_path(const py::object& value) {
  return py::isinstance<py::str>(value) || py::hasattr(value, "__fspath__");
}

/// What a table in memory is called in messages.
constexpr const char* kTrack = "track";
constexpr const char* kCampaign = "campaign";

apps::TrackFile track_in(const py::object& track) {
  if (!py::hasattr(track, "keys"))
    throw UsageError(
        fmt::format("the track must be a path or a dict of columns, not {}", Py_TYPE(track.ptr())->tp_name));
  std::optional<apps::Json> meta;
  if (track.contains("meta")) {
    const py::object given = track["meta"];
    if (!given.is_none()) meta = to_json(given, kTrack);
  }
  return apps::track_file_of(kTrack, csv_of(track, kTrack), meta);
}

apps::FitChoices choices_of(const py::dict& options) {
  apps::FitChoices choices;
  choices.tracks = text_in(options, "tracks");
  choices.loss = text_in(options, "loss");
  const auto whole = [&](const char* name, long least, long most) {
    const long value = whole_in(options, name).value_or(least);
    if (value < least || value > most)
      throw UsageError(fmt::format("--{} must be {} to {}, not {}", name, least, most, value));
    return value;
  };
  choices.allow_missing = static_cast<int>(whole("allow_missing", 0, 1'000'000));
  choices.fit.bootstrap = static_cast<int>(whole("bootstrap", 0, 1'000'000));
  if (choices.fit.bootstrap > 0 && choices.fit.bootstrap < 20)
    throw UsageError(fmt::format("--bootstrap must be 0 or at least 20, not {}", choices.fit.bootstrap));
  choices.fit.bootstrap_seed = static_cast<unsigned>(whole("seed", 0, 4294967295));
  choices.fit.rivals = truth_in(options, "compare_models");
  return choices;
}

/// What fitting hands to Python.
struct Fitted {
  apps::Json json;
  std::vector<apps::Reservation> reservations;
};

/// How another program's track is to be read.
apps::TrackReading reading_of(const py::dict& options) {
  const auto above_zero = [&](const char* key) {
    const auto value = number_in(options, key);
    if (value && !(*value > 0)) throw UsageError(fmt::format("{} must be greater than 0", key));
    return value;
  };
  const auto one_of = [&](const char* key, const std::vector<std::string>& words) {
    std::string word = text_in(options, key);
    if (!word.empty() && std::ranges::find(words, word) == words.end())
      throw UsageError(fmt::format("{} must be one of {}, not \"{}\"", key, fmt::join(words, ", "), word));
    return word;
  };
  apps::TrackReading reading;
  reading.unit = one_of("track_unit", {"px", "um", "mm", "cm", "m"});
  const std::string y = one_of("track_y", {"up", "down"});
  if (!y.empty()) reading.y = y == "up" ? apps::TrackReading::YAxis::up : apps::TrackReading::YAxis::down;
  reading.point = text_in(options, "track_point");
  reading.mark = text_in(options, "track_mark");
  reading.mm_per_px = above_zero("mm_per_px");
  reading.frame_rate_hz = above_zero("fps");
  return reading;
}

}  // namespace

py::dict measure(const py::object& track, const py::dict& options) {
  apps::MeasureChoices choices;
  choices.omega_rad_s = number_in(options, "omega_rad_s");
  choices.epsilon_rad = number_in(options, "epsilon_rad");
  choices.cycles = number_in(options, "cycles");
  choices.gravity_m_s2 = number_in(options, "gravity_m_s2");
  choices.free_slide = truth_in(options, "free_slide");
  const apps::TrackReading how = reading_of(options);
  const std::string name = is_path(track) ? path_of(track) : kTrack;
  std::optional<apps::TrackFile> given;
  if (!is_path(track)) given = track_in(track);
  const auto result = released<apps::TrackMeasurement>([name, how, choices, given](const Tell&) {
    const apps::TrackFile table =
        given ? *given : reading(name, [&] { return apps::read_any_track(name, how); });
    return apps::measure_track(name, table, choices);
  });
  if (!result.failure.empty()) warn_of_quality(result.failure);
  return to_python(result.json);
}

py::dict fit(const py::object& campaign, const py::dict& options, const py::object& progress) {
  const apps::FitChoices choices = choices_of(options);
  const std::string part = text_in(options, "part");
  apps::Context context;
  context.quiet = true;
  context.threads = static_cast<int>(whole_in(options, "threads").value_or(0));
  std::shared_ptr<const apps::Campaign> read;
  if (is_path(campaign)) {
    const std::string file = path_of(campaign);
    read = reading(file, [&] {
      return std::make_shared<const apps::Campaign>(
          apps::campaign_of_part(apps::read_campaign(apps::campaign_file(file)), part));
    });
  } else {
    if (!py::isinstance<py::dict>(campaign))
      throw UsageError(fmt::format("the campaign must be a path, a dict or a table, not {}",
                                   Py_TYPE(campaign.ptr())->tp_name));
    read = std::make_shared<const apps::Campaign>(
        apps::campaign_of_part(apps::campaign_of(to_json(campaign, kCampaign), kCampaign), part));
  }
  const auto result = released<Fitted>(
      [read, choices, context](const Tell& tell) mutable {
        context.progress = tell;
        apps::FittedCampaign fitted = apps::fit_campaign(*read, choices, context);
        auto found = apps::reservations(*read, fitted.stage, "identifiability and next_experiment");
        return Fitted{std::move(fitted.stage.json), std::move(found)};
      },
      progress);
  for (const apps::Reservation& reservation : result.reservations) {
    std::string sentence = reservation.sentence;
    for (const std::string& remedy : reservation.remedies) sentence += "\n  " + remedy;
    warn_of_quality(sentence);
  }
  return to_python(result.json);
}

}  // namespace tribotrack::python
