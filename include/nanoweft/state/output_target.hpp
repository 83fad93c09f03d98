/// Checks of the places that a run will write to, made before it starts: nothing of another's is
/// overwritten, and no result is lost for want of a folder.
#pragma once

#include <mpi.h>

#include <optional>
#include <string>
#include <vector>

#include "nanoweft/base/output_file.hpp"
#include "nanoweft/base/provenance.hpp"

namespace nanoweft {

/// What a run may replace: results of a run of the same provenance, and nothing that it reads.
struct ReplaceRule {
  Provenance run;                   ///< of this run
  bool overwrite = false;           ///< results of other runs may be replaced
  std::vector<std::string> inputs;  ///< files that this run reads, never to be replaced
  std::string restart;              ///< checkpoint that this run goes on from; it may be replaced
  std::optional<Provenance>
      checkpoint;  ///< of that checkpoint, when a restart may have another step
};

/// How another run differs from this one, as in "it has -damping_local 0.3, this run 0.9"; empty
/// when it does not.
std::string differenceOfRuns(const Provenance& other, const Provenance& mine);

/// Throws InputError unless a state may be written to `file`. Collective. What stands there is
/// remembered: `claimTarget` compares.
void refuseForeignTarget(MPI_Comm comm, const std::string& file, const ReplaceRule& rule);

/// Sets `replaced` to what stands under the name, and checks that the run `mine` may replace it:
/// the file that `refuseForeignTarget` found or that this process has put there since or, where
/// neither is known, a state file of the same run. Returns why it may not, or nothing. Not
/// collective; for the rank that writes.
std::string claimTarget(const std::string& file, const Provenance& mine, FileIdentity& replaced);
/// Remembers that this process put `written` under the name.
void noteTarget(const std::string& file, const FileIdentity& written);

/// Throws InputError when `file` cannot be made. Touches nothing. Collective.
void requireWritable(MPI_Comm comm, const std::string& file);

/// Creates the folder that `file` lies in, where it is missing. Throws InputError. Collective.
void makeParentFolder(MPI_Comm comm, const std::string& file);

}  // namespace nanoweft
