#include "apps/open/campaign_text.h"

#include <fmt/format.h>

#include <algorithm>

#include "apps/program/errors.h"
#include "apps/text/strict_toml.h"

namespace tribotrack::apps {

namespace {

Json values_in(StrictTable& table);

Json list_in(StrictTable& table, const std::string& key) {
  const std::size_t count = table.count(key);
  try {
    return table.numbers(key, count).value();
  } catch (const InvalidInput&) {
  }
  try {
    return table.texts(key).value();
  } catch (const InvalidInput&) {
  }
  Json list = Json::array();
  for (StrictTable& one : table.tables(key)) list.push_back(values_in(one));
  return list;
}

Json values_in(StrictTable& table) {
  Json values = Json::object();
  for (const std::string& key : table.keys()) {
    if (table.is_table(key)) {
      StrictTable inner = table.table(key).value();
      values[key] = values_in(inner);
    } else if (table.is_list(key)) {
      values[key] = list_in(table, key);
    } else {
      values[key] = table.written(key);
      if (values[key] == "") {
        try {
          values[key] = table.boolean(key).value();
        } catch (const InvalidInput&) {  // an empty text, or a date, which no key takes
        }
      }
    }
  }
  return values;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    lines.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
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

bool is_heading(std::string_view line, const std::string& heading) {
  line = bare(line);
  return line.starts_with(heading) && bare(line.substr(heading.size())).find('=') == line.npos;
}

/// Does any table begin here, be it as a comment?
bool is_any_heading(std::string_view line) {
  line = bare(line);
  if (!line.starts_with('[')) return false;
  line.remove_prefix(line.starts_with("[[") ? 2 : 1);
  const std::size_t end = line.find_first_not_of("abcdefghijklmnopqrstuvwxyz_.");
  return end != line.npos && end > 0 && line[end] == ']';
}

/// Is the key set in this line, live or as a comment?
bool sets(std::string_view line, const std::string& key) {
  line = bare(line);
  if (!line.starts_with(key)) return false;
  line.remove_prefix(key.size());
  const std::size_t next = line.find_first_not_of(" \t");
  return next != line.npos && line[next] == '=';
}

/// Where the value that begins at `begin` ends: of brackets and quotes, at the last.
std::size_t end_of_value(std::string_view text, std::size_t begin) {
  int depth = 0;
  char quote = 0;
  std::size_t end = begin;
  for (std::size_t k = begin; k < text.size(); ++k) {
    const char c = text[k];
    if (quote != 0) {
      if (c == '\\' && quote == '"') ++k;
      if (c == quote) quote = 0;
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '#' || (c == '\n' && depth == 0)) {
      if (c == '#' && depth > 0) {
        k = std::min(text.find('\n', k), text.size());
        continue;
      }
      break;
    } else if (c == '[' || c == '{') {
      ++depth;
    } else if (c == ']' || c == '}') {
      --depth;
    }
    if (c != ' ' && c != '\t' && c != '\r') end = std::min(k + 1, text.size());
  }
  return end;
}

/// "key = value   # comment" with another value: the comment stays where it stood, if there is room.
std::string line_with(std::string_view line, const std::string& value) {
  if (is_comment(line)) line = bare(line);
  const std::size_t begin = std::min(line.find_first_not_of(" \t", line.find('=') + 1), line.size()),
                    end = end_of_value(line, begin),
                    remark = std::min(line.find_first_not_of(" \t", end), line.size());
  const std::string set = std::string(line.substr(0, begin)) + value;
  const std::string_view comment = line.substr(remark);
  // What `init` says of a guess does not hold of what a person has written.
  if (comment.empty() || comment.starts_with("# guess") || comment.find("fill it in") != comment.npos)
    return set;
  const std::size_t gap = std::min<std::size_t>(2, remark - end);
  return fmt::format("{:<{}}{}", set, std::max(set.size() + gap, gap > 1 ? remark : 0), comment);
}

struct Block {
  std::size_t begin, end;  ///< lines, that of the heading first
};

std::optional<Block> block_of(const std::vector<std::string>& lines, const CampaignEdit& edit) {
  const bool of_run = edit.section == "run";
  const std::string heading = of_run ? "[[run]]" : "[" + edit.section + "]";
  std::optional<Block> found;
  std::size_t seen = 0;
  for (std::size_t k = 0; k < lines.size() && !found; ++k) {
    if (!is_heading(lines[k], heading) || (of_run && (is_comment(lines[k]) || seen++ != edit.run))) continue;
    found = {k, k + 1};
  }
  if (!found) return found;
  while (found->end < lines.size() && !is_any_heading(lines[found->end])) ++found->end;
  return found;
}

/// Into the lines of the section's block.
void set_in_block(std::vector<std::string>& lines, const Block& block, const CampaignEdit& edit) {
  std::optional<std::size_t> live, remark;
  std::size_t last = block.begin;
  for (std::size_t k = block.begin + 1; k < block.end; ++k) {
    if (!is_comment(lines[k]) && bare(lines[k]).find('=') != std::string_view::npos) last = k;
    if (!sets(lines[k], edit.key)) continue;
    auto& found = is_comment(lines[k]) ? remark : live;
    if (!found) found = k;
  }
  if (edit.value.empty()) {
    if (live) lines[*live] = "# " + lines[*live];
    return;
  }
  if (live) {
    // A list over several lines: all of them.
    std::size_t end = *live + 1;
    std::string whole = lines[*live];
    const std::size_t begin = whole.find('=') + 1;
    const auto open = [&] {
      return std::ranges::count(whole, '[') > std::ranges::count(whole, ']') && end < block.end;
    };
    while (open()) whole += "\n" + lines[end++];
    lines[*live] = end > *live + 1 ? whole.substr(0, begin) + " " + edit.value : line_with(whole, edit.value);
    lines.erase(lines.begin() + static_cast<std::ptrdiff_t>(*live) + 1,
                lines.begin() + static_cast<std::ptrdiff_t>(end));
  } else if (remark) {
    lines[*remark] = line_with(lines[*remark], edit.value);
  } else {
    lines.insert(lines.begin() + static_cast<std::ptrdiff_t>(last) + 1,
                 fmt::format("{} = {}", edit.key, edit.value));
  }
}

Json& place_in(Json& values, const CampaignEdit& edit) {
  if (edit.section == "run") return values["run"][edit.run];
  Json* at = &values;
  for (std::size_t begin = 0; begin < edit.section.size();) {
    const std::size_t end = std::min(edit.section.find('.', begin), edit.section.size());
    at = &(*at)[edit.section.substr(begin, end - begin)];
    begin = end + 1;
  }
  return *at;
}

/// A value alone, which TOML can read.
Json value_of(const CampaignEdit& edit, const std::string& name) {
  if (edit.value.find('\n') != std::string::npos)
    throw InvalidInput(fmt::format("{}: {} takes one line", name, edit.key));
  const Json read = values_of_campaign(edit.key + " = " + edit.value + "\n", edit.key);
  if (read.size() != 1 || !read.contains(edit.key))
    throw InvalidInput(fmt::format("{}: `{}` is no value of {}", name, edit.value, edit.key));
  return read[edit.key];
}

std::string with_edit(const std::string& text, const CampaignEdit& edit, const std::string& name) {
  const auto word = [](const std::string& s) {
    return !s.empty() && s.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_.") == s.npos;
  };
  if (!word(edit.key) || !word(edit.section)) throw InvalidInput(name + ": no such key");
  Json wanted = values_of_campaign(text, name);
  if (edit.section == "run" && (!wanted.contains("run") || edit.run >= wanted["run"].size()))
    throw InvalidInput(fmt::format("{}: has no [[run]] number {}", name, edit.run + 1));
  Json& place = place_in(wanted, edit);
  if (place.is_null()) place = Json::object();
  if (edit.value.empty())
    place.erase(edit.key);
  else
    place[edit.key] = value_of(edit, name);

  std::vector<std::string> lines = lines_of(text);
  std::optional<Block> block = block_of(lines, edit);
  if (block && is_comment(lines[block->begin]) && !edit.value.empty())
    lines[block->begin] = std::string(bare(lines[block->begin]));
  if (!block && !edit.value.empty()) {  // before the runs, which are the last
    const auto first =
        std::ranges::find_if(lines, [](const std::string& line) { return is_heading(line, "[[run]]"); });
    const auto at = lines.insert(first, {"[" + edit.section + "]", ""});
    block =
        Block{static_cast<std::size_t>(at - lines.begin()), static_cast<std::size_t>(at - lines.begin()) + 1};
  }
  if (block) set_in_block(lines, *block, edit);
  std::string changed = text_of_lines(lines);
  bool done = false;
  try {
    done = nlohmann::json(values_of_campaign(changed, name)) == nlohmann::json(wanted);  // in any order
  } catch (const InvalidInput&) {
  }
  if (!done)
    throw InvalidInput(
        fmt::format("{}: {} is written in a way that only a person can change (an inline or a dotted "
                    "table); change it in the file",
                    name, edit.key));
  return changed;
}

}  // namespace

Json values_of_campaign(const std::string& text, const std::string& name) {
  StrictTable table = StrictTable::parse(text, name);
  return values_in(table);
}

namespace {

/// Does this line of `init` ask for what is there by now?
bool is_answered(const std::string& line, const Json& values) {
  constexpr std::string_view kAsks = "# TO FILL IN: ";
  if (!line.starts_with(kAsks)) return false;
  const std::string asked = line.substr(kAsks.size());
  const auto has = [&](const char* section, const char* key) {
    return values.contains(section) && values[section].contains(key);
  };
  if (asked.starts_with("diameter_mm in [part]"))
    return has("part", "diameter_mm") || has("camera", "mm_per_px");
  if (asked.starts_with("frame_rate_hz in [camera]")) return has("camera", "frame_rate_hz");
  return values.contains("run") && std::ranges::any_of(values["run"], [&](const Json& run) {
           const std::string stem = std::filesystem::path(run.value("video", "")).stem().string();
           return asked.starts_with(fmt::format("phi_rad and dtau_rad of {}: ", stem)) &&
                  run.contains("phi_rad") && run.contains("dtau_rad");
         });
}

}  // namespace

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
