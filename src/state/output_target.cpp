#include "nanoweft/state/output_target.hpp"

#include <sys/stat.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <map>
#include <sstream>

#include "nanoweft/base/error.hpp"
#include "nanoweft/state/state_file.hpp"
#include "nanoweft/state/state_read.hpp"

namespace nanoweft {

namespace {

/// What this process may replace, by name behind all links: what stood there when it looked, or
/// what it has put there since.
std::map<std::string, FileIdentity>& targets() {
  static std::map<std::string, FileIdentity> known;
  return known;
}

/// Lines "-name value" by name.
std::map<std::string, std::string> valuesByName(const std::string& options) {
  std::map<std::string, std::string> values;
  std::istringstream lines(options);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t blank = line.find(' ');
    values[line.substr(0, blank)] = blank == std::string::npos ? "" : line.substr(blank + 1);
  }
  return values;
}

std::string onRank0(MPI_Comm comm, const auto& find) {
  int rank;
  MPI_Comm_rank(comm, &rank);
  return rank == 0 ? find() : std::string();
}

/// Why the file under this name is none that a run may replace, whatever its content.
std::string problemOfKind(const std::string& file, const ReplaceRule& rule) {
  const std::string what = "cannot write a state to " + file + ": ";
  if (std::filesystem::path(file).filename().empty()) return what + "it is a folder";
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) return errno == ENOENT ? "" : what + std::strerror(errno);
  if (S_ISDIR(status.st_mode)) return what + "it is a folder";
  if (!S_ISREG(status.st_mode)) return what + "it is no regular file (a fifo, socket or device)";
  for (const std::string& input : rule.inputs)
    if (FileIdentity::of(input).sameFile(FileIdentity::of(file)))
      return "will not replace " + file + ": this run starts from it; choose another name";
  if ((status.st_mode & (S_IWUSR | S_IWGRP | S_IWOTH)) == 0)
    return "will not replace " + file + ": it is write-protected";
  return "";
}

/// Why the state file under this name is not this run's to replace.
std::string problemOfOwner(const std::string& file, const ReplaceRule& rule) {
  CheckedState found;
  try {
    found = checkState(file, Trust::program);
  } catch (const InputError& problem) {
    return "will not overwrite " + file +
           ": it is not a nanoweft state file in good order; remove it or choose another name (" +
           problem.what() + ")";
  }
  const bool restarts =
      !rule.restart.empty() && FileIdentity::of(rule.restart).sameFile(FileIdentity::of(file));
  if (rule.overwrite || restarts) return "";
  const std::string remedy = "; remove it, choose another name, or give -overwrite";
  if (!found.byProgram)
    return "will not replace " + file + ": no run of this program wrote it" + remedy;
  if (rule.checkpoint && found.run.sameRun(*rule.checkpoint)) return "";
  const std::string difference = differenceOfRuns(found.run, rule.run);
  if (difference.empty()) return "";
  return "will not replace " + file + ": another run wrote it (" + difference + ")" + remedy;
}

}  // namespace

std::string differenceOfRuns(const Provenance& other, const Provenance& mine) {
  if (other.program != mine.program) return "its program is '" + other.program + "'";
  const auto theirs = valuesByName(other.options), ours = valuesByName(mine.options);
  for (const auto& [name, value] : theirs) {
    const auto found = ours.find(name);
    if (found == ours.end()) return "it has " + name + " " + value + ", this run not";
    if (found->second != value)
      return "it has " + name + " " + value + ", this run " + found->second;
  }
  for (const auto& [name, value] : ours)
    if (!theirs.contains(name)) return "this run has " + name + " " + value + ", it not";
  if (other.input.empty() && !mine.input.empty())
    return "it does not say which file it started from";
  if (other.input != mine.input) return "it started from another file";
  if (other.version != mine.version)
    return "it is of version '" + other.version + "', this run of '" + mine.version + "'";
  return other == mine ? "" : "its options are in another order";
}

void refuseForeignTarget(MPI_Comm comm, const std::string& file, const ReplaceRule& rule) {
  agree<InputError>(comm, onRank0(comm, [&] {
                      std::string problem = problemOfKind(file, rule);
                      // Noted before the look, so that a change during it is noticed.
                      const FileIdentity there = FileIdentity::of(file);
                      if (problem.empty() && there.exists) problem = problemOfOwner(file, rule);
                      if (problem.empty()) noteTarget(file, there);
                      return problem;
                    }));
}

std::string claimTarget(const std::string& file, const Provenance& mine, FileIdentity& replaced) {
  replaced = FileIdentity::of(file);
  const std::string place = throughLinks(file);
  if (const auto known = targets().find(place); known != targets().end()) {
    // A file that was removed meanwhile cannot be overwritten.
    if (!replaced.exists || replaced == known->second) return "";
    return "will not replace " + file + ": something else has written it since this run looked";
  }
  if (!replaced.exists) return "";
  ReplaceRule rule;
  rule.run = mine;
  const std::string problem = problemOfKind(file, rule);
  return problem.empty() ? problemOfOwner(file, rule) : problem;
}

void noteTarget(const std::string& file, const FileIdentity& written) {
  targets()[throughLinks(file)] = written;
}

void requireWritable(MPI_Comm comm, const std::string& file) {
  agree<InputError>(comm, onRank0(comm, [&] { return OutputFile(file).problem(); }));
}

void makeParentFolder(MPI_Comm comm, const std::string& file) {
  agree<InputError>(comm, onRank0(comm, [&] {
                      const auto folder = std::filesystem::path(file).parent_path();
                      std::error_code code;
                      if (!folder.empty()) std::filesystem::create_directories(folder, code);
                      return code ? "cannot make the folder " + folder.string() + ": " +
                                        code.message()
                                  : std::string();
                    }));
}

}  // namespace nanoweft
