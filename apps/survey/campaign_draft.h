// A campaign to start from: every key explained, what recordings show filled in and marked as a guess.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "apps/files/campaign/data_section.h"
#include "apps/program/context.h"

namespace tribotrack::apps {

/// A value that a draft fills in, as TOML, and how it is known.
struct DraftValue {
  std::string value;
  std::string why;
  bool missing = false;  ///< written as a comment: it is for the user to fill in
};

using DraftTable = std::map<std::string, DraftValue, std::less<>>;

struct CampaignDraft {
  std::map<std::string, DraftTable, std::less<>> tables;  ///< by section
  std::vector<DraftTable> runs;
  std::vector<std::string> left_out;  ///< recordings that cannot be read, each with the reason
  std::vector<std::string> missing;   ///< what the user must fill in before `run`, one sentence each
};

struct DraftOptions;
/// What the user gives of the part and the frame rate, written into the draft. Throws UsageError.
void take_given(const DraftOptions& options, CampaignDraft& draft);

/// Recordings directly in a folder: files with the name of a recording, and folders of pictures; by name.
std::vector<std::filesystem::path> recordings_in(const std::filesystem::path& folder);

struct DraftOptions {
  std::filesystem::path folder;  ///< of the campaign: recordings are named relative to it
  std::optional<double> diameter_mm, chamfer_mm, fps;  ///< as the user gives them
  bool marks_with_runs = false;                        ///< not under [camera], though all recordings agree
  /// Of recordings that belong to the same campaign: what one name leaves open, another may tell.
  std::vector<std::string> other_names = {};
  /// Keys of [[run]] that a list gives, for each recording where there is a list: they stand against what is
  /// guessed.
  std::vector<Json> listed = {};
};

/// A path as a campaign in this folder names it.
std::string relative_to(const std::filesystem::path& path, const std::filesystem::path& folder);

/// Looks into every recording (vision/survey.h) and at its name (survey_text.h), with all threads. Throws
/// InvalidInput where none of them can be read.
CampaignDraft draft_of(const std::vector<std::filesystem::path>& recordings, const DraftOptions& options,
                       const Context& context);

/// The same with a list of runs, whose files lie in `from`: one [[run]] for each line, in its order, with
/// what the recording shows where the line is silent. A line names its recording by path, name, or name
/// without suffix, in any case of letters. Throws InvalidInput naming the lines whose recording is not there;
/// recordings that no line names are left out.
CampaignDraft draft_of(const RunList& list, const std::filesystem::path& from, DraftOptions options,
                       const Context& context);

/// The one of some recordings that a list means by a name; none where it could be several.
std::optional<std::filesystem::path> recording_named(const std::string& name,
                                                     const std::vector<std::filesystem::path>& recordings,
                                                     const std::filesystem::path& folder);

/// A [[run]] of it, with an empty line before.
std::string toml_of_run(const DraftTable& run);

/// Writes a campaign that can be read. Throws InvalidInput where its text cannot; then the file stays as it
/// was.
void write_campaign(const std::filesystem::path& file, const std::string& text);

/// The campaign as TOML. Keys that the draft does not fill in are comments with an example.
std::string toml_of(const CampaignDraft& draft);

}  // namespace tribotrack::apps
