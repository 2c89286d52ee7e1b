#include "apps/open/campaign_text.h"

#include <fmt/format.h>

#include <toml++/toml.h>
#include <algorithm>

#include "apps/program/errors.h"
#include "apps/text/angle.h"
#include "apps/text/strict_toml.h"

namespace tribotrack::apps {

namespace {

std::string_view written(std::string_view text, const toml::node& node) {
  const auto& [begin, end, path] = node.source();
  const std::size_t from = offset_of(text, begin.line, begin.column);
  return text.substr(from, offset_of(text, end.line, end.column) - from);
}

Json values_in(const toml::node& node, std::string_view text) {
  Json values = Json::object();
  if (const toml::table* table = node.as_table()) {
    for (const auto& [key, value] : *table) values[std::string(key.str())] = values_in(value, text);
    return values;
  }
  if (const toml::array* list = node.as_array()) {
    values = Json::array();
    for (const toml::node& item : *list)
      values.push_back(item.is_number() ? Json(*item.value<double>()) : values_in(item, text));
    return values;
  }
  if (const auto word = node.value<std::string>()) return *word;
  return node.is_boolean() ? Json(*node.value<bool>()) : Json(std::string(written(text, node)));
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines = parts_of(text, '\n');
  if (lines.back().empty()) lines.pop_back();
  return lines;
}

std::string text_of_lines(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

/// A line without blanks at its beginning, nor the `#` of a comment.
std::string_view bare(std::string_view line) {
  const auto skip = [&](const char* what) {
    line.remove_prefix(std::min(line.find_first_not_of(what), line.size()));
  };
  skip(" \t");
  if (line.starts_with('#')) line.remove_prefix(1), skip(" \t");
  return line;
}

bool is_comment(std::string_view line) {
  const std::size_t first = line.find_first_not_of(" \t");
  return first != line.npos && line[first] == '#';
}

/// What a line sets or opens, be it as a comment: a key, "[part]", "[[run]]"; nothing for other lines.
std::string_view subject_of(std::string_view line) {
  line = bare(line);
  const std::string_view word = line.substr(0, line.find_first_of(" \t\r=#:"));
  const std::size_t behind = line.find_first_not_of(" \t\r", word.size());
  const char next = behind == line.npos ? '#' : line[behind];
  if (!word.starts_with('[')) return next == '=' ? word : "";
  const bool heading =
      word.ends_with(']') && word.find_first_not_of("[]abcdefghijklmnopqrstuvwxyz_.") == word.npos;
  return heading && (next == '#' || next == ':') ? word : "";
}

/// The text with another value for the one that stands there. What `init` says of a guess behind it does not
/// hold of what a person has written.
std::string with_value(std::string text, const toml::node& old, const std::string& value) {
  const std::string_view there = written(text, old);
  const auto begin = static_cast<std::size_t>(there.data() - text.data());
  const std::size_t end = begin + there.size(), line_end = std::min(text.find('\n', end), text.size()),
                    comment = std::min(text.find_first_not_of(" \t", end), line_end);
  const std::string_view remark = std::string_view(text).substr(comment, line_end - comment);
  const bool hint = remark.starts_with("# guess") || remark.find("fill it in") != remark.npos;
  return text.replace(begin, (hint ? line_end : end) - begin, value);
}

/// A line that sets the key, live or as a comment, with another value.
std::string line_with(std::string_view line, const CampaignEdit& edit) {
  const std::string live(bare(line));
  try {
    const toml::table read = toml::parse(live);
    if (const toml::node* old = read.get(edit.key)) return with_value(live, *old, edit.value);
  } catch (const toml::parse_error&) {  // a comment may hold anything
  }
  return fmt::format("{} = {}", edit.key, edit.value);
}

/// With a key that is not there yet: where it stands as a comment, else behind the last key of its section.
std::string with_key(const std::string& text, const CampaignEdit& edit) {
  const bool of_run = edit.section == "run";
  const std::string heading = of_run ? "[[run]]" : "[" + edit.section + "]";
  std::vector<std::string> lines = lines_of(text);
  std::size_t seen = 0;
  auto begin = std::ranges::find_if(lines, [&](const std::string& line) {
    return subject_of(line) == heading && (!of_run || (!is_comment(line) && seen++ == edit.run));
  });
  if (begin == lines.end())  // before the runs, which are the last
    begin = lines.insert(std::ranges::find(lines, "[[run]]", subject_of), {heading, ""});
  if (is_comment(*begin)) *begin = std::string(bare(*begin));

  auto last = begin;
  for (auto line = begin + 1; line != lines.end() && !subject_of(*line).starts_with('['); ++line) {
    if (is_comment(*line) && subject_of(*line) == edit.key) {
      *line = line_with(*line, edit);
      return text_of_lines(lines);
    }
    if (!is_comment(*line) && !subject_of(*line).empty()) last = line;
  }
  lines.insert(last + 1, fmt::format("{} = {}", edit.key, edit.value));
  return text_of_lines(lines);
}

/// With the lines of a value as comments.
std::string without(const std::string& text, const toml::node& old) {
  std::vector<std::string> lines = lines_of(text);
  for (toml::source_index line = old.source().begin.line; line <= old.source().end.line; ++line)
    lines[line - 1].insert(0, "# ");
  return text_of_lines(lines);
}

/// A value alone, which TOML can read.
Json value_of(const CampaignEdit& edit, const std::string& name) {
  if (edit.value.find('\n') != std::string::npos) throw InvalidInput("{}: {} takes one line", name, edit.key);
  const Json read = values_of_campaign(edit.key + " = " + edit.value + "\n", edit.key);
  if (read.size() != 1 || !read.contains(edit.key))
    throw InvalidInput("{}: `{}` is no value of {}", name, edit.value, edit.key);
  return read[edit.key];
}

std::string with_edit(const std::string& text, const CampaignEdit& edit, const std::string& name) {
  const auto word = [](const std::string& s) {
    return !s.empty() && s.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_.") == s.npos;
  };
  if (!word(edit.key) || !word(edit.section)) throw InvalidInput(name + ": no such key");
  const bool of_run = edit.section == "run";
  std::string path = of_run ? fmt::format("run/{}", edit.run) : edit.section;
  std::ranges::replace(path, '.', '/');
  const Json::json_pointer place("/" + path);
  Json wanted = values_of_campaign(text, name);
  if (of_run && !wanted.contains(place))
    throw InvalidInput("{}: has no [[run]] number {}", name, edit.run + 1);
  const toml::table file = toml::parse(text);
  const auto section = of_run ? file["run"][edit.run] : file.at_path(edit.section);
  const toml::node* old = section[edit.key].node();
  if (!old && edit.value.empty()) return text;
  if (edit.value.empty())
    wanted[place].erase(edit.key);
  else
    wanted[place / edit.key] = value_of(edit, name);
  const std::string changed = !old                 ? with_key(text, edit)
                              : edit.value.empty() ? without(text, *old)
                                                   : with_value(text, *old, edit.value);
  bool done = false;
  try {
    done = nlohmann::json(values_of_campaign(changed, name)) == nlohmann::json(wanted);  // in any order
  } catch (const InvalidInput&) {
  }
  if (!done)
    throw InvalidInput(
        "{}: {} is written in a way that only a person can change (an inline or a dotted table); change it "
        "in the file",
        name, edit.key);
  return changed;
}

/// Does this line of `init` ask for what is there by now?
bool is_answered(std::string_view line, const Json& values) {
  constexpr std::string_view kAsks = "# TO FILL IN: ";
  if (!line.starts_with(kAsks)) return false;
  line.remove_prefix(kAsks.size());
  const auto has = [&](const char* place) { return values.contains(Json::json_pointer(place)); };
  if (line.starts_with("diameter_mm in [part]")) return has("/part/diameter_mm") || has("/camera/mm_per_px");
  if (line.starts_with("frame_rate_hz in [camera]")) return has("/camera/frame_rate_hz");
  return values.contains("run") && std::ranges::any_of(values["run"], [&](const Json& run) {
           const std::string stem = std::filesystem::path(run.value("video", "")).stem().string();
           return line.starts_with(fmt::format("phi_rad and dtau_rad of {}: ", stem)) &&
                  run.contains("phi_rad") && run.contains("dtau_rad");
         });
}

}  // namespace

Json values_of_campaign(const std::string& text, const std::string& name) {
  StrictTable::parse(text, name);  // refuses what is no TOML
  return values_in(toml::parse(text), text);
}

std::string with_edits(std::string text, const std::vector<CampaignEdit>& edits, const std::string& name) {
  for (const CampaignEdit& edit : edits) text = with_edit(text, edit, name);
  std::vector<std::string> lines = lines_of(text);
  const Json values = values_of_campaign(text, name);
  return std::erase_if(lines, [&](const std::string& line) { return is_answered(line, values); }) > 0
             ? text_of_lines(lines)
             : text;
}

std::string with_recording(std::string text, const std::string& recording) {
  if (!text.empty() && text.back() != '\n') text += '\n';
  return text + "\n[[run]]\nvideo = " + toml_text(recording) + "\n";
}

}  // namespace tribotrack::apps
