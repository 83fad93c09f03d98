#include "nanoweft/app/provenance.hpp"

#include <filesystem>

#include "nanoweft/base/canonical.hpp"
#include "nanoweft/base/digest.hpp"
#include "nanoweft/base/error.hpp"

namespace nanoweft {

namespace {

/// SHA-256 of a file, read by rank 0; empty when there is no such file.
std::string digestOnAll(MPI_Comm comm, const std::string& file) {
  int rank;
  MPI_Comm_rank(comm, &rank);
  std::string digest, problem;
  std::error_code code;
  if (rank == 0 && std::filesystem::is_regular_file(file, code)) try {
      digest = sha256OfFile(file);
    } catch (const InputError& failure) {
      problem = failure.what();
    }
  agree<InputError>(comm, problem);
  auto length = static_cast<int>(digest.size());
  MPI_Bcast(&length, 1, MPI_INT, 0, comm);
  digest.resize(static_cast<std::size_t>(length));
  MPI_Bcast(digest.data(), length, MPI_CHAR, 0, comm);
  return digest;
}

/// The file that a scene reads.
struct SceneFile {
  std::string option, name;
};

/// The file that the scene's option names, or empty.
SceneFile sceneFile(const Options& options) {
  for (const char* option : {"scene_file", "text_file", "lammps_file"}) {
    const auto it = options.readings().find(option);
    if (it != options.readings().end() && it->second.value) return {option, *it->second.value};
  }
  return {};
}

/// Why a run cannot go on from a file with this record, or empty.
std::string noCheckpoint(const RunRecord& run) {
  if (run.reals.empty() && run.integers.empty() && run.texts.empty())
    return "this is no checkpoint: it holds a state alone (it has no group /run)";
  const auto purpose = run.texts.find(purposeText);
  if (purpose == run.texts.end() || !run.texts.contains(optionsText))
    return "it does not say what options it was made with (an older version of nanoweft wrote it)";
  if (purpose->second == snapshotPurpose) return "this is no checkpoint but a snapshot";
  if (purpose->second == finalPurpose) return "this is no checkpoint but a final state";
  if (purpose->second != checkpointPurpose)
    return "this is no checkpoint but '" + purpose->second + "'";
  return "";
}

}  // namespace

Provenance readProvenance(MPI_Comm comm, const Options& options, const StateHeader* start,
                          bool restart) {
  Provenance result{"nanoweft", NANOWEFT_VERSION, options.resultOptions({"seed"}),
                    start ? start->digest : ""};
  const auto [option, file] = sceneFile(options);
  if (!restart) {
    if (!start && !file.empty()) result.input = digestOnAll(comm, file);
    return result;
  }
  const Provenance first = provenanceOf(start->run);
  result.input = first.input;
  const std::string& name = start->run.source;
  if (!file.empty() && first.input.empty() && option == "scene_file")
    throw InputError(
        format("-%s %s: the checkpoint %s was made without it; leave out -restart to start from it",
               option.c_str(), file.c_str(), name.c_str()));
  const std::string input = file.empty() ? "" : digestOnAll(comm, file);
  if (!input.empty() && !first.input.empty() && input != first.input)
    throw InputError(
        format("-%s %s: the checkpoint %s was made from another file (or from one of other "
               "content); leave out -restart to start from this one, or -%s to go on",
               option.c_str(), file.c_str(), name.c_str(), option.c_str()));
  return result;
}

StateHeader openCheckpoint(MPI_Comm comm, const std::string& file, Options& options) {
  StateHeader header = readStateHeader(comm, file);
  if (const std::string problem = noCheckpoint(header.run); !problem.empty())
    throw InputError(
        format("-restart %s: %s; start a run from it with -scene file -scene_file %s instead",
               file.c_str(), problem.c_str(), file.c_str()));
  const Provenance first = provenanceOf(header.run);
  if (first.program != "nanoweft")
    throw InputError(
        format("-restart %s: '%s' wrote it, not nanoweft", file.c_str(), first.program.c_str()));
  std::map<std::string, std::string> inForce;
  if (const auto fire = header.run.reals.find("fire"); fire != header.run.reals.end()) {
    if (fire->second.size() == 3) inForce["ts_dt"] = canonical(fire->second[1]);
  } else {
    inForce["ts_dt"] = canonical(header.run.needReals("time_step", 1)[0]);
  }
  options.goOnFrom(file, first.options, inForce);
  return header;
}

void requireParts(const StateHeader& checkpoint, const ExtraFields& extras) {
  for (const std::string& part : partsOfState(extras))
    if (!checkpoint.parts.contains(part))
      throw InputError(
          format("-restart %s: its /state/%s is missing or empty, without which the run cannot go "
                 "on",
                 checkpoint.run.source.c_str(), part.c_str()));
  if (checkpoint.run.reals.contains("links") && !checkpoint.parts.contains("link"))
    throw InputError(format("-restart %s: its /link is missing, without which the run cannot go on",
                            checkpoint.run.source.c_str()));
}

}  // namespace nanoweft
