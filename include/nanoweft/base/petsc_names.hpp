/// Names of options that are PETSc's own, beside those of nanoweft.
#pragma once

#include <string>
#include <string_view>

namespace nanoweft {

/// May PetscInitialize or an object of PETSc read it here? Without its dash.
bool belongsToPetsc(std::string_view name);

/// Do names of PETSc's own options begin with this word and an underscore (-draw_...)?
bool beginsPetscOptions(const std::string& word);

}  // namespace nanoweft
