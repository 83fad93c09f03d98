#include "nanoweft/base/petsc_names.hpp"

#include <algorithm>

namespace nanoweft {

namespace {

/// Options that PetscInitialize and PETSc's own objects may read here.
constexpr std::string_view petscNames[] = {
    "help",
    "version",
    "skip_petscrc",
    "options_file",
    "options_file_yaml",
    "options_string_yaml",
    "options_left",
    "options_view",
    "options_monitor",
    "options_monitor_cancel",
    "options_suppress_deprecated_warnings",
    "citations",
    "log",
    "log_all",
    "log_view",
    "log_view_memory",
    "log_trace",
    "log_sync",
    "log_mpe",
    "log_exclude",
    "log_include_actions",
    "log_include_objects",
    "info",
    "info_exclude",
    "malloc",
    "malloc_debug",
    "malloc_dump",
    "malloc_hbw",
    "malloc_test",
    "malloc_view",
    "malloc_view_threshold",
    "malloc_requested_size",
    "malloc_coalesce",
    "memory_view",
    "fp_trap",
    "on_error_abort",
    "on_error_attach_debugger",
    "on_error_emacs",
    "on_error_mpiabort",
    "error_output_none",
    "error_output_stdout",
    "start_in_debugger",
    "debugger_nodes",
    "debugger_pause",
    "debugger_ranks",
    "debug_terminal",
    "stop_for_debugger",
    "no_signal_handler",
    "checkstack",
    "objects_dump",
    "get_total_flops",
    "history",
    "nox",
    "nox_warning",
    "display",
    "shared_tmp",
    "not_shared_tmp",
    "tmp",
    "use_gpu_aware_mpi",
    "mpi_linear_solver_server",
    "build_twosided",
    "x_virtual",
    // Of windows, which -..._monitor draw opens.
    "draw_bounds",
    "draw_cmap",
    "draw_cmap_brighten",
    "draw_cmap_reverse",
    "draw_coordinates",
    "draw_double_buffer",
    "draw_fast",
    "draw_marker_type",
    "draw_pause",
    "draw_popup",
    "draw_ports",
    "draw_save",
    "draw_save_final_image",
    "draw_save_movie",
    "draw_save_movie_fps",
    "draw_save_on_clear",
    "draw_save_on_flush",
    "draw_save_single_file",
    "draw_size",
    "draw_type",
    "draw_virtual",
    "draw_x_shared_colormap",
    // Of its objects, which are made later.
    "dm_view",
    "sf_type",
    "viewer_binary_mpiio",
    "viewer_hdf5_collective",
};
/// What options of PETSc's objects begin with.
constexpr std::string_view petscPrefixes[] = {"draw_",          "sf_",        "dm_", "viewer_hdf5_",
                                              "viewer_binary_", "vecscatter_"};

}  // namespace

bool belongsToPetsc(std::string_view name) {
  return std::ranges::find(petscNames, name) != std::end(petscNames);
}

bool beginsPetscOptions(const std::string& word) {
  return std::ranges::any_of(petscPrefixes, [&](std::string_view p) { return word + "_" == p; });
}

}  // namespace nanoweft
