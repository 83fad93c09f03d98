/// Bad input and failed runs, as a user meets them: one clear line, the right exit status on any
/// number of ranks, no file lost.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <regex>

#include "nanoweft/base/hdf5.hpp"
#include "support/expect.hpp"
#include "support/program.hpp"

using namespace nanoweft;
using namespace nanoweft::test;

namespace {

const std::string fibre = "-scene fibre -fibre_segments 12 -ts_max_steps 2 ";
const std::string hamaker = "-pair hamaker -hamaker_constant 0.5 -hamaker_gap 3 ";
const std::string weave = "-scene weave -weave_fibres 4,4 -weave_segments 24 -ts_max_steps 2 ";
const std::string fromFile = "-scene file -scene_file in.h5 -ts_max_steps 2 ";

const std::string held = "-bc hold -hold_region -9,-9,-9,9,9,9 ";

/// Options for so many groups of one segment.
std::string regions(int count) {
  std::string names, options;
  for (int k = 0; k < count; ++k) {
    const std::string name = "g" + std::to_string(k);
    names += (names.empty() ? "" : ",") + name;
    options += "-" + name + "_region -1,-1,-1,1,1,1 -" + name + "_fix 1,1,1 ";
  }
  return "-bc " + names + " " + options;
}

/// Every file of the folder but the program's output, with its bytes.
std::map<std::string, std::string> contents(const Folder& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder.path()))
    if (const auto name = entry.path().lexically_relative(folder.path()).string();
        name != "out.txt")
      files[name] = entry.is_regular_file() ? readFile(entry.path().string()) : "";
  return files;
}

/// in.h5: one straight fibre of 12 segments, as an outsider would write it.
void good(const Folder& folder) {
  writeState(folder / "in.h5", {straightFibre({0, 0, 0}, {1, 0, 0}, 12)});
}

/// Puts a dataset into in.h5, in the place of the one it has.
void put(const Folder& folder, const std::string& name, std::vector<hsize_t> shape,
         const std::vector<double>& values) {
  h5::silence();
  h5::Handle f(H5Fopen((folder / "in.h5").c_str(), H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose);
  const std::string path = "state/" + name;
  H5Ldelete(f, path.c_str(), H5P_DEFAULT);
  if (shape.empty()) return;
  h5::Handle space(H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr),
                   H5Sclose);
  h5::Handle set(
      H5Dcreate2(f, path.c_str(), H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
      H5Dclose);
  H5Dwrite(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
}

/// Changes one number of in.h5.
void change(const Folder& folder, const std::string& name, hsize_t columns, std::size_t at,
            double value) {
  good(folder);
  auto values = readDataset(folder / "in.h5", "state/" + name);
  values[at] = value;
  const hsize_t rows = values.size() / columns;
  put(folder, name, columns == 1 ? std::vector<hsize_t>{rows} : std::vector<hsize_t>{rows, columns},
      values);
}

void attribute(const Folder& folder, const char* name, const auto& value) {
  good(folder);
  h5::Handle f(H5Fopen((folder / "in.h5").c_str(), H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose);
  h5::Handle group(H5Gopen2(f, "state", H5P_DEFAULT), H5Gclose);
  H5Adelete(group, name);
  h5::writeAttribute(group, name, value);
}

void emptyHdf5(const std::string& file) {
  h5::Handle f(H5Fcreate(file.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose);
  h5::Handle group(H5Gcreate2(f, "results", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
}

void truncated(const Folder& folder) {
  good(folder);
  std::filesystem::resize_file(folder / "in.h5", std::filesystem::file_size(folder / "in.h5") / 2);
}

/// Two fibres that cross 5 A apart, at segment 6 of the one and segment 4 of the other.
void crossing(const Folder& folder) {
  writeState(folder / "in.h5", {straightFibre({-6 * 13.56, 0, 0}, {1, 0, 0}, 13),
                                straightFibre({0, -4 * 13.56, 5}, {0, 1, 0}, 9)});
}

struct Case {
  std::string name, options;
  std::vector<std::string> fragments;
  std::function<void(const Folder&)> prepare = {};
};

void PrintTo(const Case& c, std::ostream* out) {
  *out << c.name;
}

/// An input file `name` with this text.
auto text(std::string name, std::string content) {
  return [=](const Folder& folder) { writeText(folder / name, content); };
}

const std::vector<Case> cases = {
    // Scenes that cannot be laid.
    {"SceneKindUnknown",
     "-scene bundle -bundle_kinds glass -ts_max_steps 2",
     {"-bundle_kinds: 'glass' is not among -kinds"}},
    {"SceneShares",
     "-kinds a,b -scene bundle -bundle_kinds a,b -bundle_shares 0.5,0.6 -ts_max_steps 2",
     {"-bundle_shares", "add to 1"}},
    {"RingTooTight",
     "-scene ring -ring_segments 30 -ring_windings 5 -ts_max_steps 2",
     {"-ring_segments 30", "5 windings", "take"}},
    {"RacketLoop", "-scene racket -racket_loop 9 -ts_max_steps 2", {"-racket_loop 9"}},
    {"HelixTooDense",
     "-scene helix -helix_pitch 10 -ts_max_steps 2",
     {"-helix_pitch 10", "of the gap"}},
    {"RopePlies", "-scene rope -rope_plies 3,0 -ts_max_steps 2", {"-rope_plies", "whole numbers"}},
    {"RopeLay", "-scene rope -rope_lay 500,20 -ts_max_steps 2", {"-rope_lay 20", "two diameters"}},
    {"FilmTooDense",
     "-scene film -film_size 400,400 -film_segments 20 -film_fraction 0.9 -ts_max_steps 2",
     {"-film_fraction 0.9", "as laid"}},
    {"FilmPersistence",
     "-scene film -film_persistence 20 -ts_max_steps 2",
     {"-film_persistence 20", "twelve segments"}},
    {"FilmBundlesOfWorms",
     "-scene film -film_layers 3 -film_bundle 5 -film_persistence 500 -ts_max_steps 2",
     {"-film_bundle 5", "straight fibres in -film_layers"}},
    {"NetworkTooDense",
     "-scene network -network_size 300,300,300 -network_segments 15 -network_fraction 0.5 "
     "-ts_max_steps 2",
     {"-scene network: no place for fibre", "fill a fraction of"}},
    {"NetworkFibresAndFraction",
     "-scene network -network_fibres 3 -network_fraction 0.1 -ts_max_steps 2",
     {"-network_fibres and -network_fraction"}},
    {"ArrayTooDense",
     "-scene array -array_wave 30,300 -ts_max_steps 2",
     {"-array_spacing", "amplitude"}},
    {"BraidOfTwo", "-scene braid -braid_strands 2 -ts_max_steps 2", {"-braid_strands"}},
    {"KnitTooNarrow", "-scene knit -knit_width 40 -ts_max_steps 2", {"-knit_width 40"}},
    {"SatinStep",
     "-weave_pattern satin -weave_float 6,2 -ts_max_steps 2",
     {"-weave_float", "divisor"}},
    {"BasketOfTwoNumbers",
     "-weave_pattern basket -weave_float 2,3 -ts_max_steps 2",
     {"-weave_float", "a 1"}},
    {"TwillOutOfItsPitch",
     "-weave_pattern twill -weave_fibres 20,20 -weave_segments 100 -weave_periodic -weave_pitch 68 "
     "-ts_max_steps 2",
     {"-weave_pitch 68", "strains the bonds along x"}},
    {"TwillTooShort",
     "-weave_pattern twill -weave_fibres 8,8 -weave_segments 50 -weave_pitch 200 -ts_max_steps 2",
     {"-weave_pitch 200", "do not reach across"}},
    {"TowsTooThick",
     "-weave_fibres 5,5 -weave_segments 20 -weave_filaments 6,2 -ts_max_steps 2",
     {"-weave_segments", "tows of 6 x 2"}},
    {"NoTextFile", "-scene text -ts_max_steps 2", {"-text_file"}},
    {"MissingTextFile",
     "-scene text -text_file nowhere.txt -ts_max_steps 2",
     {"-text_file nowhere.txt"}},
    {"TextFileLine",
     "-scene text -text_file in.txt -ts_max_steps 2",
     {"in.txt, line 2", "three numbers"},
     text("in.txt", "0 0 0\n10 x 0\n")},
    {"TextFileOnePoint",
     "-scene text -text_file in.txt -ts_max_steps 2",
     {"in.txt, line 2", "fewer than two points"},
     text("in.txt", "0 0 0\n\n10 0 0\n")},
    {"TextFibreTooShort",
     "-scene text -text_file in.txt -ts_max_steps 2",
     {"in.txt: fibre 1 is 8 long", "less than 2 segments of 13.56"},
     text("in.txt", "0 0 0\n0 40 0\n\n0 0 50\n0 8 50\n")},
    {"NoLammpsFile", "-scene lammps -ts_max_steps 2", {"-lammps_file"}},
    // Files that are missing, damaged or foreign.
    {"MissingOptionsFile", "-options_file nowhere.opts", {"-options_file nowhere.opts"}},
    {"MissingOptionsFileInOptionsFile",
     "-options_file run.opts",
     {"nowhere.opts"},
     text("run.opts", "-options_file nowhere.opts\n")},
    {"OptionsFileWithoutDash",
     "-options_file run.opts",
     {"run.opts"},
     text("run.opts", "-scene fibre\nts_max_steps 2\n")},
    {"OptionsFileTwoOnALine",
     "-options_file run.opts",
     {"run.opts"},
     text("run.opts", "-scene fibre -ts_max_steps 2\n")},
    {"OptionsFileOfItself",
     "-options_file run.opts",
     {"run.opts"},
     text("run.opts", "-ts_max_steps 2\n-options_file run.opts\n")},
    {"OptionsFileBinary",
     "-options_file run.opts -ts_max_steps 2",
     {"run.opts"},
     text("run.opts", std::string("\0\1\2\xff rubbish\n", 13))},
    {"MissingSceneFile",
     "-scene file -scene_file nowhere.h5 -ts_max_steps 2",
     {"nowhere.h5", "does not exist"}},
    {"NoSceneFile", "-scene file -ts_max_steps 2", {"-scene_file"}},
    {"MissingRestart", fibre + "-restart nowhere.h5", {"nowhere.h5", "does not exist"}},
    {"FolderAsRestart", fibre + "-restart .", {"it is a folder"}},
    {"TruncatedSceneFile", fromFile, {"state file in.h5 cannot be used", "HDF5"}, truncated},
    {"TruncatedRestart",
     fibre + "-restart in.h5",
     {"state file in.h5 cannot be used", "HDF5"},
     truncated},
    {"TextAsStateFile",
     fromFile,
     {"state file in.h5 cannot be used", "HDF5"},
     text("in.h5", "fibre x y z\n1 0 0 0\n")},
    {"EmptyStateFile", fromFile, {"state file in.h5 cannot be used", "HDF5"}, text("in.h5", "")},
    {"ForeignHdf5", fromFile, {"in.h5", "/state"}, [](const Folder& f) { emptyHdf5(f / "in.h5"); }},
    {"OtherFormat",
     fromFile,
     {"in.h5", "format", "nanoweft-state"},
     [](const Folder& f) { attribute(f, "format", std::string("other-state")); }},
    {"OtherVersion",
     fromFile,
     {"in.h5", "version"},
     [](const Folder& f) { attribute(f, "version", std::vector<std::int64_t>{2}); }},
    {"OtherUnits",
     fromFile,
     {"in.h5", "units si", "-units nano"},
     [](const Folder& f) { attribute(f, "units", std::string("si")); }},
    {"BoxNotANumber",
     fromFile,
     {"in.h5", "lower"},
     [](const Folder& f) {
       attribute(f, "lower", std::vector<double>(3, std::numeric_limits<double>::quiet_NaN()));
     }},
    {"MissingDataset",
     fromFile,
     {"in.h5", "/state/index", "missing"},
     [](const Folder& f) { good(f), put(f, "index", {}, {}); }},
    {"WrongShape",
     fromFile,
     {"in.h5", "/state/orientation", "[N, 4]"},
     [](const Folder& f) {
       good(f), put(f, "orientation", {12, 3}, std::vector<double>(36));
     }},
    {"WrongRows",
     fromFile,
     {"in.h5", "/state/velocity", "[N, 3]"},
     [](const Folder& f) {
       good(f), put(f, "velocity", {11, 3}, std::vector<double>(33));
     }},
    {"NoSegments",
     fromFile,
     {"in.h5", "/state/position"},
     [](const Folder& f) {
       good(f), put(f, "position", {0, 3}, {});
     }},
    {"RowsOutOfOrder",
     fromFile,
     {"in.h5", "row 5", "index 7", "ordered"},
     [](const Folder& f) { change(f, "index", 1, 5, 7); }},
    {"PositionNotANumber",
     fromFile,
     {"in.h5", "row 7", "fibre 0", "index 7", "position"},
     [](const Folder& f) {
       change(f, "position", 3, 22, std::numeric_limits<double>::quiet_NaN());
     }},
    {"NoUnitQuaternion",
     fromFile,
     {"in.h5", "row 0", "unit quaternion", "norm"},
     [](const Folder& f) { change(f, "orientation", 4, 0, 2); }},
    {"UnknownFibreClosed",
     fromFile,
     {"in.h5", "fibre_closed", "77"},
     [](const Folder& f) { good(f), put(f, "fibre_closed", {1}, {77}); }},
    {"ClosedFibreOfTwo",
     fromFile,
     {"in.h5", "fibre_closed", "three"},
     [](const Folder& f) {
       writeState(f / "in.h5", {straightFibre({0, 0, 0}, {1, 0, 0}, 2)});
       put(f, "fibre_closed", {1}, {0});
     }},
    // Options that are unknown, or mean nothing in this run.
    {"Misspelt", fibre + "-ts_max_stps 3", {"-ts_max_stps", "-ts_max_steps"}},
    {"MisspeltShort", fibre + "-v 3", {"unknown option -v; -help lists all"}},
    {"WithoutItsTopic", fibre + "-dt 3", {"-dt; known ones like it: -ts_dt, -ts_dt_unsafe\n"}},
    {"OnlyItsTopic",
     fibre + "-damping 0.1",
     {"unknown option -damping; known ones like it: -damping_local, -damping_viscous, "
      "-damping_viscous_angular\n"}},
    {"OnlyBegun", fibre + "-damp_visc 1", {"known ones like it: -damping_viscous, -damping_v"}},
    {"InAnotherOrder",
     fibre + "-tension_strain_max 1",
     {"the nearest known one is -tension_max_strain\n"}},
    {"MisspeltBehindAKind",
     "-kinds a,b -weave_kinds a,b -a_fibre_radus 9 -ts_max_steps 2",
     {"the nearest known one is -fibre_radius\n"}},
    {"BoundaryWithoutAName", fibre + "-grip_force 1,0,0", {"must be named: -bc grip\n"}},
    {"StrayWord", fibre + "extra", {"extra"}},
    {"PitchOfFileScene",
     fromFile + "-weave_pitch 60",
     {"-weave_pitch", "not used", "-scene is not weave"},
     good},
    {"SpliceWithoutPairs",
     fibre + "-pair none -vdw_splice kink",
     {"-vdw_splice", "not used", "-pair is none"}},
    {"StressWithoutTension",
     fibre + "-stress_monitor ascii:stress.csv",
     {"-stress_monitor", "-tension_rate"}},
    // Values that are none.
    {"StepIsAWord", fibre + "-ts_dt abc", {"-ts_dt 'abc'", "number"}},
    {"StepIsNegative", fibre + "-ts_dt -1", {"-ts_dt -1", "above 0"}},
    {"StepWithoutValue", fibre + "-ts_dt", {"-ts_dt", "number"}},
    {"HalfASegmentMore", fibre + "-ts_max_steps 1.5", {"-ts_max_steps '1.5'", "whole number"}},
    {"TooManyPoints", fibre + "-pair_points 100", {"-pair_points 100", "1 to 99"}},
    {"NoPoints", fibre + "-pair_points 0", {"-pair_points 0", "1 to 99"}},
    {"ThicknessOfNothing",
     fibre + "-deform_thickness 10",
     {"-deform_thickness", "there is no -box_monitor"}},
    {"PointsAndAccuracy",
     fibre + "-pair_points 5 -pair_accuracy 0.1",
     {"-pair_points", "-pair_accuracy chooses"}},
    {"AccuracyOutOfReach",
     fibre + "-pair hertz -pair_accuracy 1e-6",
     {"-pair_accuracy 1e-06: not reached with"}},
    {"SplitInTheSwitch", fibre + "-pair_far_from 50", {"-pair_far_from 50", "17.3436", "40.68"}},
    {"DampingOfTwo", fibre + "-damping_local 2", {"-damping_local 2", "at most 1"}},
    {"OneNumberOfFibres", weave + "-weave_fibres 3", {"-weave_fibres '3'", "2 numbers"}},
    {"TwoDirections", fibre + "-domain_periodic 1,1", {"-domain_periodic '1,1'", "three"}},
    {"HalfPrecision", weave + "-pair_precision half", {"-pair_precision 'half'", "double|single"}},
    {"SingleHertz",
     fibre + "-pair hertz -pair_precision single",
     {"-pair_precision", "not used", "-pair is hertz"}},
    {"RoundSplice", fibre + "-vdw_splice round", {"-vdw_splice 'round'", "smooth|kink"}},
    {"PairNothing", fibre + "-pair nothing", {"-pair 'nothing'", "vdw", "none"}},
    {"PairOfNothingElse", fibre + "-pair none,vdw", {"-pair vdw,none", "stands alone"}},
    {"PairTwice", fibre + "-pair hertz,hertz", {"-pair 'hertz,hertz'", "twice"}},
    {"PairAddsNothing", fibre + "-pair vdw,glue", {"-pair 'vdw,glue'", "capillary|contact|none"}},
    {"HamakerWithoutConstant",
     fibre + "-pair hamaker -hamaker_gap 3 -pair_gap_cutoff 40",
     {"-hamaker_constant", "needs it", "eV"}},
    {"HamakerWithoutEnd", fibre + hamaker, {"-hamaker_gap_cutoff", "needs it", "gap"}},
    {"HamakerEndsAtRest",
     fibre + hamaker + "-pair_gap_cutoff 3",
     {"-hamaker_gap_cutoff", "gap at rest, 3"}},
    {"HamakerEndsBelowZero",
     fibre + hamaker + "-pair_gap_cutoff -30",
     {"-pair_gap_cutoff -30", "above 0"}},
    {"HamakerSwitchedBackwards",
     fibre + hamaker + "-pair_gap_switch 35 -pair_gap_cutoff 30",
     {"from a gap of 35 to 30 A", "rise"}},
    {"HamakerWithTwoEnds",
     fibre + hamaker + "-pair_gap_cutoff 30 -hamaker_gap_cutoff 40",
     {"-hamaker_gap_cutoff", "-pair_gap_cutoff", "one of the two"}},
    {"HamakerRepels", fibre + "-pair hamaker -hamaker_constant -1", {"constant -1", "above 0"}},
    {"HydrogenOfNoNumber",
     fibre + "-pair hydrogen -hydrogen_energy nan",
     {"-hydrogen_energy 'nan'", "number"}},
    {"BridgeThatDoesNotWet",
     fibre + "-pair capillary -capillary_tension 0.0045 -capillary_angle 2",
     {"-capillary_angle 2", "at most 1.57"}},
    {"AnglesOfTwoKinds",
     "-kinds a,b -weave_kinds a,b -pair capillary,contact -capillary_tension 0.0045 "
     "-capillary_volume 1000 -contact_modulus 10 -a_a_capillary_angle 0.5 -ts_max_steps 1",
     {"-a_b_capillary_angle", "needs it"}},
    {"OneRangeForTwoLaws",
     fibre + "-pair vdw,hydrogen -hydrogen_energy 0.02 -hydrogen_gap 3 -pair_gap_cutoff 30",
     {"-pair_gap_cutoff", "not used", "-vdw_gap_", "-hydrogen_gap_"}},
    {"BridgeWithoutCapillary", fibre + "-capillary_angle 1", {"-capillary_angle", "-pair is vdw"}},
    {"SceneNothing", "-scene nothing -ts_max_steps 2", {"-scene 'nothing'", "weave|fibre|bundle"}},
    {"ForeignViewer",
     fibre + "-energy_monitor hdf5:old.h5",
     {"-energy_monitor", "ascii or draw"},
     [](const Folder& f) {
       writeState(f / "old.h5", {straightFibre({0, 0, 0}, {1, 0, 0}, 12)});
     }},
    // Runs that make no sense.
    {"NoEnd", "-scene fibre -fibre_segments 12", {"no end", "-ts_max_steps", "-tension_rate"}},
    {"StepTooLarge", weave + "-ts_dt 60", {"-ts_dt 60", "stable step", " fs", "-ts_dt_unsafe"}},
    {"Overlap",
     fromFile,
     {"fibre 0 segment 6", "fibre 1 segment 4", "5 A", "-pair_allow_overlap"},
     crossing},
    {"ThinBox", fibre + "-domain_periodic 0,1,0", {"periodic box", "along y", "108.48"}},
    {"OddPeriodicWeave", weave + "-weave_periodic -weave_fibres 3,4", {"-weave_fibres", "even"}},
    {"RegionWithoutMembers",
     fibre + "-bc hold -hold_region 900,900,900,901,901,901 -hold_fix 1,1,1",
     {"-bc hold", "no segment", "region"}},
    {"BoundaryWithANameOfPetsc",
     fibre + "-bc dm -dm_region -9,-9,-9,9,9,9 -dm_fix 1,1,1",
     {"-bc", "'dm'", "PETSc"}},
    {"BoundaryWithoutAction",
     fibre + "-bc hold -hold_region -9,-9,-9,9,9,9",
     {"-bc hold", "-hold_fix", "-hold_force"}},
    {"StrainWithoutATest",
     fibre + "-tension_max_strain 0.1",
     {"-tension_max_strain", "no tension"}},
    {"GripWithoutATest", fibre + "-tension_grip 20", {"-tension_grip", "no tension test"}},
    {"KinkStiffnessWithoutKinks", fibre + "-fibre_kink_stiffness 0.5", {"-fibre_kink_stiffness"}},
    {"RampOfNothing", fibre + held + "-hold_fix 1,1,1 -hold_ramp 100", {"-hold_ramp", "not used"}},
    {"StressOfAnOpenBox", fibre + "-box_monitor ascii:b.csv", {"-box_monitor", "open"}},
    {"SurfacesThatRestAtNoDistance", fibre + "-vdw_alpha 4.1", {"-vdw_alpha", "would rest"}},
    {"DirectionBeyondAllNumbers", fibre + "-fibre_direction 1e200,1e200,0", {"-fibre_direction"}},
    {"AxisBeyondAllNumbers",
     fibre + held + "-hold_spin 1e-5 -hold_centre 0,0,0 -hold_axis 0,0,1e200",
     {"-hold_axis 1e200", "to 1e+60"}},
    {"AxisWithoutDirection",
     fibre + held + "-hold_spin 1e-5 -hold_centre 0,0,0 -hold_axis 0,0,0",
     {"-hold_axis", "no direction"}},
    {"NumberBeyondAllProducts",
     fibre + "-fibre_segment_inertia 1e300",
     {"-fibre_segment_inertia 1e300", "to 1e+60"}},
    {"NumberTooSmallForProducts", fibre + "-ts_dt 1e-300", {"-ts_dt 1e-300", "1e-60"}},
    {"ModulusBesideStiffnesses",
     fibre + "-fibre_bond_stiffness 60,20,-4,1.5 -fibre_young 500",
     {"-fibre_young", "-fibre_bond_stiffness"}},
    {"PointsOfContactsAlone",
     fibre + "-pair contact -contact_modulus 20 -pair_points 5",
     {"-pair_points", "-pair is contact"}},
    {"HeldWithEmptyParts",
     fibre + "-bc hold -hold_region -9,-9,-9,9,9,9 -hold_fix 1,,",
     {"-hold_fix '1,,'", "three of 0 and 1"}},
    {"CentreWithoutTurning",
     fibre + held + "-hold_fix 1,1,1 -hold_centre 0,0,9",
     {"-hold_centre", "-hold_spin"}},
    {"RampOfAVelocityOfZero",
     fibre + held + "-hold_velocity 0,0,0 -hold_ramp 100",
     {"-hold_ramp", "not used"}},
    {"RestUnderAWallThatMovesForEver",
     fibre + "-walls w -w_point 0,0,-22 -w_axis 0,0,1 -w_modulus 20 -w_velocity 0,0,1e-4 "
             "-relax_tolerance 1e-3",
     {"-relax_tolerance", "-w_stop"}},
    {"RestInABoxThatIsStrainedForEver",
     "-scene weave -weave_periodic -weave_fibres 4,4 -weave_segments 24 -deform_x rate "
     "-deform_x_rate 1e-7 -relax_tolerance 1e-3",
     {"-relax_tolerance", "-deform_x_until"}},
    {"AccuracyBetweenKinds",
     "-kinds a,b -a_b_pair_accuracy 0.01 -weave_kinds a,b -weave_fibres 4,4 -weave_segments 24 "
     "-ts_max_steps 2",
     {"-a_b_pair_accuracy", "widths"}},
    {"SinglePrecisionOfMorePointsThanItHas",
     fibre + "-pair_precision single -pair_points 12",
     {"-pair_precision single"}},
    {"SharesOfOneFibre", "-scene ring -ring_shares 1", {"unknown option -ring_shares"}},
    {"KindsOfOneFibre",
     "-kinds a,b -scene ring -ring_kinds a,b -ts_max_steps 2",
     {"-ring_kinds", "one fibre"}},
    {"NetworkOfNoFibre",
     "-scene network -network_fraction 1e-9 -ts_max_steps 2",
     {"-network_fraction", "not one fibre"}},
    {"CylinderThatSlidesInItself",
     fibre + "-walls w -w_shape cylinder -w_inside -w_radius 99 -w_point 0,0,0 -w_axis 1,0,0 "
             "-w_modulus 20 -w_velocity 0.01,0,0",
     {"-w_velocity", "-w_friction"}},
    {"StickingOfKindsWithoutFriction",
     "-kinds a,b -pair contact -contact_modulus 20 -contact_tangential 0.5 -weave_kinds a,b "
     "-weave_fibres 4,4 -weave_segments 24 -ts_max_steps 2",
     {"-contact_tangential", "-contact_friction"}},
    {"KinkBeyondFlow",
     fibre + "-fibre_kink_curvature 0.01 -fibre_yield_curvature 0.005",
     {"-fibre_yield_curvature", "-fibre_kink_curvature"}},
    {"UnknownOptionLikeThoseOfPetsc", fibre + "-dm_nonsense 3", {"unknown option -dm_nonsense"}},
    {"SwitchTooNarrow",
     fibre + "-pair_switch 54.23",
     {"fades from 54.23 to 54.24", "-pair_switch"}},
    {"RepulsionThatReplacesTheWell",
     fibre + "-vdw_stiffness 1",
     {"-vdw_stiffness 1", "2.958", "-vdw_splice kink"}},
    {"BoundaryTwice",
     fibre + "-bc hold,hold -hold_region -9,-9,-9,9,9,9 -hold_fix 1,1,1",
     {"-bc", "'hold' stands there twice"}},
    {"BoundaryWithANameThatPetscCuts",
     fibre + "-bc hold,hold_1 -hold_region -9,-9,-9,9,9,9 -hold_fix 1,1,1",
     {"-bc", "'hold_1' cannot name a group"}},
    {"BoundaryInCapitals",
     fibre + "-bc hold,Hold -hold_region -9,-9,-9,9,9,9 -hold_fix 1,1,1",
     {"-bc", "twice"}},
    {"LoadOnWhatIsHeld",
     fibre + held + "-hold_fix 1,0,1 -hold_force 0,1,1e-3",
     {"-hold_force", "z component"}},
    {"TorqueOnWhatIsHeld",
     fibre + held + "-hold_fix_rotation -hold_torque 0,0,1",
     {"-hold_torque"}},
    {"SteepWeave",
     "-weave_gap 80 -weave_fibres 4,4 -weave_segments 20 -ts_max_steps 0",
     {"-weave_segments", "too steep", "-weave_segments"}},
    {"FibreTooShortForItsKind",
     "-kinds a,b -b_fibre_preset mwcnt_100_10 -scene bundle -bundle_kinds a,b "
     "-bundle_segments 6 -bundle_fibres 2",
     {"the kind b", "take 23"}},
    {"FrictionOfKindsThatDiffer",
     "-kinds a,b -pair contact -contact_modulus 20 -a_a_contact_friction 0.5 -scene bundle "
     "-bundle_kinds a,b -bundle_fibres 2 -bundle_segments 10",
     {"-a_b_contact_friction", "differ"}},
    {"BoundaryWithANameOfTheTest",
     fibre + "-bc tensionx -tensionx_region -9,-9,-9,9,9,9 -tensionx_fix 1,1,1",
     {"-bc tensionx", "tension test"}},
    {"BoundaryWithCornersExchanged",
     fibre + "-bc hold -hold_region 9,-9,-9,-9,9,9 -hold_fix 1,1,1",
     {"-hold_region", "lower corner"}},
    {"BoundaryWithTwoKindsOfMembers",
     fibre + held + "-hold_group 1 -hold_fix 1,1,1",
     {"-bc hold", "either -hold_region or -hold_group"}},
    {"BoundaryMovesWhatItDoesNotHold",
     fibre + held + "-hold_fix 1,0,1 -hold_velocity 0,1e-4,0",
     {"-hold_velocity", "y component", "-hold_fix"}},
    {"BraidTooLongToLookAt", "-scene braid -braid_lay 1e9", {"-braid_lay 1e+09", "too many"}},
    {"RopeTooLongToLookAt", "-scene rope -rope_lay 1e9,-1e8", {"-rope_lay 1e+09", "too many"}},
    {"RopeTooWideToLookAt", "-scene rope -rope_gap 1e6", {"-rope_lay", "too many"}},
    {"KnitTooWideToLookAt", "-scene knit -knit_width 1e8", {"-knit_width 1e+08", "too many"}},
    {"StepsBeyondAllIntegers", fibre + "-ts_max_steps 1e17", {"-ts_max_steps 1e17", "from"}},
    {"RangeBeyondAllTables", weave + "-pair_cutoff 1e50", {"-pair_cutoff", "reach to 1e+50"}},
    {"CoverageBeyondAllFibres",
     "-scene film -film_size 400,400 -film_segments 20 -film_coverage 1e17 -ts_max_steps 0",
     {"-film_coverage", "1e8"}},
    {"SlopeOfFlatLayers",
     "-scene film -film_layers 3 -film_coverage 0.3 -film_slope 0.1 -ts_max_steps 0",
     {"-film_slope", "-film_layers"}},
    {"FireWithInternalViscosity",
     fibre + "-fibre_retardation 10 -relax_method fire",
     {"-fibre_retardation"}},
    {"StickingWithoutFriction",
     fibre + "-pair contact -contact_modulus 20 -contact_tangential 0.5",
     {"-contact_tangential", "-contact_friction"}},
    {"KinkBeyondAFold", fibre + "-fibre_kink_curvature 0.3", {"-fibre_kink_curvature", "4.07 rad"}},
    {"WallThatSlidesInItself",
     fibre + "-walls w -w_point 0,0,-22 -w_axis 0,0,1 -w_modulus 20 -w_velocity 0.01,0,0",
     {"-w_velocity", "-w_friction"}},
    {"FrictionBeyondAllSurfaces",
     fibre + "-pair contact -contact_modulus 10 -contact_friction 1e50",
     {"-contact_friction", "1000"}},
    {"FireWithFriction",
     fibre + "-pair contact -contact_modulus 10 -contact_friction 0.3 -relax_method fire",
     {"-relax_method fire", "friction", "-contact_friction"}},
    {"ShearWithATensionTest",
     weave + "-weave_periodic -deform_xy rate -deform_xy_rate 1e-6 -tension_rate 1e-6 "
             "-tension_axis z -tension_width 100",
     {"-deform", "tension test"}},
    {"StrainWithATensionTest",
     weave + "-weave_periodic -deform_x free -tension_rate 1e-6 -tension_axis z",
     {"-deform_x", "tension test"}},
    {"ExclusionTooLongForBreakage",
     fibre + "-pair_exclude 100 -break_strain_mean 0.2",
     {"-pair_exclude 100", "with breakage"}},
    {"ThicknessOfSeveralKinds",
     "-kinds a,b -weave_kinds a,b -weave_fibres 4,4 -weave_segments 24 -ts_max_steps 2 "
     "-tension_rate 1e-6 -tension_grip 30",
     {"-tension_thickness", "several kinds"}},
    {"BoundaryWithoutMembers",
     fibre + "-bc hold -hold_fix 1,1,1",
     {"-bc hold", "-hold_region", "-hold_group"}},
    {"SpinWithoutAxis",
     fibre + held + "-hold_spin 1e-5 -hold_centre 0,0,0",
     {"-hold_spin", "-hold_axis", "-hold_centre"}},
    {"AxisWithoutSpin", fibre + held + "-hold_fix 1,1,1 -hold_axis 1,0,0", {"-hold_axis", "spin"}},
    {"AxisOfNoDirection",
     fibre + held + "-hold_spin 1e-5 -hold_centre 0,0,0 -hold_axis 0,0,0",
     {"-hold_axis", "no direction"}},
    {"SpinHeldInPart",
     fibre + held + "-hold_spin 1e-5 -hold_centre 0,0,0 -hold_axis 1,0,0 -hold_fix 1,0,1",
     {"-hold_fix", "-hold_axis", "not y"}},
    {"SpinAcrossAPeriodicBox",
     weave + "-weave_periodic " + held + "-hold_spin 1e-5 -hold_centre 0,0,0 -hold_axis 1,0,0",
     {"-hold_spin", "periodic along y"}},
    {"FireWithASpin",
     fibre + "-relax_method fire " + held + "-hold_spin 1e-5 -hold_centre 0,0,0 -hold_axis 1,0,0",
     {"-relax_method fire", "-hold_spin", "no rest"}},
    {"TwoHoldersOfOneSegment",
     fibre + "-bc a,b -a_region -1,-1,-1,30,1,1 -a_fix 1,1,1 -b_region 20,-1,-1,60,1,1 "
             "-b_velocity 0,1e-5,0",
     {"-bc: a and b", "y velocity of 1 segment "}},
    {"TwoHoldersOfARotation",
     fibre + "-bc a,b -a_region -1,-1,-1,30,1,1 -a_fix_rotation -b_region 10,-1,-1,60,1,1 "
             "-b_spin 1e-5 -b_axis 1,0,0 -b_centre 0,0,0",
     {"-bc: a and b", "rotation of 2 segments"}},
    {"HolderInAGrip",
     fibre + held + "-hold_fix 1,0,0 -tension_rate 1e-6 -tension_grip 20 -tension_width 10",
     {"-bc: hold and the lower grip", "x velocity of 1 segment "}},
    {"ManyRegions", fibre + regions(13), {"-bc: 13 names", "at most 12", "-NAME_group"}},
    {"GroupTableWithoutGroups", fibre + "-group_monitor ascii:g.csv", {"-group_monitor", "-bc"}},
    {"OddProgram", fibre + "-tension_program 0.02,1e-6,0.01", {"-tension_program", "pairs", "odd"}},
    {"ProgramWithARateBelowZero",
     fibre + "-tension_program 0.02,1e-6,0,-1e-6",
     {"-tension_program", "rate -1e-06", "positive"}},
    {"ProgramBeyondTheGrips",
     fibre + "-tension_program -1,1e-6",
     {"-tension_program", "strain -1"}},
    {"ProgramThatStands",
     fibre + "-tension_program 0.02,1e-6,0.02,1e-7",
     {"-tension_program", "strain 0.02 twice"}},
    {"ProgramAndRate",
     fibre + "-tension_program 0.02,1e-6 -tension_rate 1e-6",
     {"-tension_rate", "not used", "-tension_program"}},
    {"ProgramAndEnd",
     fibre + "-tension_program 0.02,1e-6 -tension_max_strain 0.1",
     {"-tension_max_strain", "not used", "-tension_program"}},
    {"NoRate", fibre + "-tension_rate 0", {"-tension_rate 0"}},
    {"EndThatIsNeverReached",
     fibre + "-tension_rate -1e-6 -tension_max_strain 0.1 -tension_grip 20 -tension_width 10",
     {"-tension_max_strain 0.1", "-1e-06", "other way"}},
    {"LateralStrainOfALine",
     fibre +
         "-tension_rate 1e-6 -tension_grip 20 -tension_width 10 -tension_lateral -stress_monitor "
         "ascii:s.csv",
     {"-tension_lateral", "no width along y"}},
    {"TensionEnds",
     fibre + "-tension_rate 1e-6 -tension_ends 100,20",
     {"-tension_ends 100,20", "lower end"}},
    {"TensionEndsBesideThePiece",
     fibre + "-tension_rate 1e-6 -tension_width 10 -tension_ends 5000,6000",
     {"-tension_ends 5000,6000", "upper grip"}},
    {"LongGrips", fibre + "-tension_rate 1e-6 -tension_grip 100", {"-tension_grip 100", "149.16"}},
    {"FireWithTension", weave + "-relax_method fire -tension_rate 1e-6", {"fire", "tension test"}},
    {"FireWithDamping",
     weave + "-relax_method fire -damping_local 0.4",
     {"-damping_local", "not used", "-relax_method fire"}},
    {"FireWithViscousDamping",
     weave + "-relax_method fire -damping_viscous 1",
     {"-damping_viscous", "not used", "-relax_method fire"}},
    {"FireWithAMovingHolder",
     fibre + "-relax_method fire -bc hold -hold_region -9,-9,-9,9,9,9 -hold_velocity 0,1e-5,0",
     {"-relax_method fire", "-hold_velocity", "no rest"}},
    {"FireWithoutEnd",
     "-scene fibre -fibre_segments 12 -relax_method fire",
     {"no end", "-relax_force"}},
    {"FireBeyondTheStableStep",
     weave + "-relax_method fire -ts_dt 60",
     {"-ts_dt 60", "stable step"}},
    {"RelaxMethodNothing", fibre + "-relax_method slow", {"-relax_method 'slow'", "fire"}},
    {"RestOfATensionTest",
     fibre + "-relax_force 1 -tension_rate 1e-6 -tension_grip 20 -tension_width 10",
     {"-relax_force", "tension test"}},
    {"RestOfAMovingGroup",
     fibre + "-relax_force 1 -bc a -a_region -99,-99,-99,99,99,99 -a_velocity 0,0,1e-5",
     {"-relax_force", "-a_velocity"}},
    {"RestAtWhichATensionTestPasses",
     fibre + "-relax_tolerance 0.1 -tension_rate 1e-6 -tension_grip 20 -tension_width 10",
     {"-relax_tolerance", "tension test"}},
    {"RestOfWhatIsKeptMoving",
     fibre + "-relax_tolerance 0.1 -bc a -a_region -99,-99,-99,99,99,99 -a_velocity 0,0,1e-5",
     {"-relax_tolerance", "-a_velocity"}},
    {"PullAcrossASheet",
     weave + "-tension_axis z -tension_rate 1e-6 -tension_grip 3",
     {"-tension_axis z", "thick along y", "-tension_thickness"}},
    {"NegativeForceTolerance", fibre + "-relax_force -1", {"-relax_force -1", "at least 0"}},
    // Output that must not be lost, or cannot be written.
    {"ForeignStateOutput",
     fibre + "-state_output notes.txt",
     {"notes.txt", "not a nanoweft state file"},
     text("notes.txt", "mine\n")},
    {"ForeignCheckpoint",
     fibre + "-checkpoint_file other.h5",
     {"other.h5", "not a nanoweft state file"},
     [](const Folder& f) { emptyHdf5(f / "other.h5"); }},
    {"DamagedStateOutput",
     fibre + "-state_output in.h5",
     {"in.h5", "not a nanoweft state file"},
     truncated},
    {"ForeignMonitor",
     fibre + "-energy_monitor ascii:notes.txt",
     {"notes.txt"},
     text("notes.txt", "mine\n")},
    {"ForeignSnapshot",
     fibre + "-snapshot_file traj",
     {"traj_0000000000.h5"},
     text("traj_0000000000.h5", "mine\n")},
    {"ForeignSnapshotIndex",
     fibre + "-snapshot_file traj",
     {"traj.xdmf"},
     text("traj.xdmf", "mine\n")},
    {"FolderAsStateOutput", fibre + "-state_output .", {"folder"}},
    {"StateBelowAFile",
     fibre + "-state_output plain/final.h5",
     {"plain", "folder"},
     text("plain", "mine\n")},
    {"CheckpointBelowAFile",
     fibre + "-checkpoint_file plain/deep/c.h5",
     {"plain", "folder"},
     text("plain", "mine\n")},
    {"SnapshotBelowAFile",
     fibre + "-snapshot_file plain/traj",
     {"plain", "folder"},
     text("plain", "mine\n")},
    {"StateInUnwritableFolder", fibre + "-state_output /proc/final.h5", {"/proc/final.h5"}},
    {"CheckpointInUnwritableFolder", fibre + "-checkpoint_file /proc/c.h5", {"/proc/c.h5"}},
    {"MonitorInUnwritableFolder",
     fibre + "-energy_monitor ascii:/proc/energy.csv",
     {"/proc/energy.csv"}},
    {"TwoMonitorsInOneFile",
     fibre + "-tension_rate 1e-6 -tension_grip 20 -tension_width 10 -energy_monitor ascii:both.csv "
             "-stress_monitor ascii:both.csv",
     {"both.csv"}},
    {"MonitorBelowAFile",
     fibre + "-energy_monitor ascii:plain/energy.csv",
     {"plain", "folder"},
     text("plain", "mine\n")},
};

class BadInput : public testing::TestWithParam<std::tuple<Case, int>> {};

TEST_P(BadInput, IsRefused) {
  const auto& [c, ranks] = GetParam();
  SCOPED_TRACE(c.options);
  const Folder folder;
  if (c.prepare) c.prepare(folder);
  // What an earlier run left, under the names that this one would write to.
  std::string outputs;
  auto output = [&](const std::string& option, const std::string& value) {
    if (c.options.find(option) == std::string::npos) outputs += " " + option + " " + value;
  };
  writeText(
      folder / "energy.csv",
      "step,time_fs,stretch,shear,bending,torsion,pair,kinetic,rotational,total,damped,external,"
      "broken\n0,0,1,2,3,4,5,6,7,8,9,10,11\n");
  writeState(folder / "final.h5", {straightFibre({0, 0, 0}, {0, 1, 0}, 3)});
  output("-energy_monitor", "ascii:energy.csv");
  output("-state_output", "final.h5");
  output("-checkpoint_file", "c.h5");
  const auto before = contents(folder);
  // That another run has written them shall not be what is wrong.
  expectRefused(run(folder, c.options + outputs + " -overwrite", ranks), c.fragments);
  const auto after = contents(folder);
  for (const auto& [name, bytes] : before)
    EXPECT_TRUE(after.contains(name) && after.at(name) == bytes) << name << " has changed";
  for (const auto& [name, bytes] : after)
    EXPECT_TRUE(before.contains(name)) << name << " was left behind";
}

std::string caseName(const testing::TestParamInfo<BadInput::ParamType>& info) {
  return std::get<0>(info.param).name + "On" + std::to_string(std::get<1>(info.param));
}

/// The first of each kind, for two ranks.
std::vector<Case> some() {
  std::vector<Case> chosen;
  for (const Case& c : cases)
    for (const char* name : {"MissingOptionsFile", "MissingRestart", "TruncatedSceneFile",
                             "PositionNotANumber", "RowsOutOfOrder", "Misspelt", "StepTooLarge",
                             "Overlap", "RegionWithoutMembers", "ForeignStateOutput"})
      if (c.name == name) chosen.push_back(c);
  return chosen;
}

/// Every third case, for four ranks: all refusals take the same way there.
std::vector<Case> thirds() {
  std::vector<Case> chosen;
  for (std::size_t k = 0; k < std::size(cases); k += 3) chosen.push_back(cases[k]);
  return chosen;
}

INSTANTIATE_TEST_SUITE_P(Each, BadInput,
                         testing::Combine(testing::ValuesIn(cases), testing::Values(1)), caseName);
INSTANTIATE_TEST_SUITE_P(Thirds, BadInput,
                         testing::Combine(testing::ValuesIn(thirds()), testing::Values(4)),
                         caseName);
INSTANTIATE_TEST_SUITE_P(Some, BadInput,
                         testing::Combine(testing::ValuesIn(some()), testing::Values(2)), caseName);

class OnRanks : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Robust, OnRanks, testing::Values(1, 4), testing::PrintToStringParamName());

/// Where the first chunk of a dataset lies in the file.
std::size_t middleOfChunk(const std::string& file, const std::string& name) {
  h5::Handle f(H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  h5::Handle set(H5Dopen2(f, name.c_str(), H5P_DEFAULT), H5Dclose);
  h5::Handle space(H5Dget_space(set), H5Sclose);
  hsize_t offset[2], size = 0;
  unsigned filters;
  haddr_t address = HADDR_UNDEF;
  if (H5Dget_chunk_info(set, space, 0, offset, &filters, &address, &size) < 0)
    throw std::runtime_error("no chunk of " + name);
  return static_cast<std::size_t>(address + size / 2);
}

TEST_P(OnRanks, FlippedByteIsRefused) {
  const Folder folder;
  ASSERT_EQ(run(folder, fibre + "-state_output good.h5").status, 0);
  const std::string bytes = readFile(folder / "good.h5");
  for (const std::string name : {"position", "orientation", "index", "velocity", "bond_broken"}) {
    SCOPED_TRACE(name);
    std::string damaged = bytes;
    damaged[middleOfChunk(folder / "good.h5", "state/" + name)] ^= 1;
    writeText(folder / "in.h5", damaged);
    expectRefused(run(folder, fromFile, GetParam()),
                  {"state file in.h5 cannot be used", "damaged", "SHA-256"});
    if (name == "position")
      expectRefused(run(folder, fibre + "-restart in.h5 -state_output in.h5", GetParam()),
                    {"in.h5", "damaged"});
    EXPECT_EQ(readFile(folder / "in.h5"), damaged);
  }
}

/// A state file damaged inside is no more to be overwritten than a truncated one.
TEST_P(OnRanks, DamagedOutputIsKept) {
  const Folder folder;
  ASSERT_EQ(run(folder, fibre + "-state_output good.h5").status, 0);
  std::string damaged = readFile(folder / "good.h5");
  damaged[middleOfChunk(folder / "good.h5", "state/position")] ^= 1;
  writeText(folder / "in.h5", damaged);
  expectRefused(run(folder, fibre + "-state_output in.h5", GetParam()), {"in.h5"});
  EXPECT_EQ(readFile(folder / "in.h5"), damaged);
}

TEST_P(OnRanks, StepTooLargeNamesTheLimitAndCanBeForced) {
  const Folder folder;
  const Outcome refused = run(folder, weave + "-ts_dt 60", GetParam());
  std::smatch found;
  ASSERT_TRUE(
      std::regex_search(refused.output, found, std::regex("stable step[^,]*, ([0-9.]+) fs")))
      << refused.output;
  const double limit = std::stod(found[1]);
  EXPECT_GT(limit, 30.0);
  EXPECT_LT(limit, 60.0);
  const Outcome forced =
      run(folder, weave + "-ts_dt 60 -ts_dt_unsafe -energy_alarm 0 -ts_max_steps 1", GetParam());
  EXPECT_EQ(forced.status, 0) << forced.output;
  expectClean(forced.output);
}

/// Stops with status 2 and says where and when; returns the step it names.
std::smatch expectUnstable(const Outcome& outcome) {
  EXPECT_EQ(outcome.status, 2) << outcome.output;
  expectClean(outcome.output);
  EXPECT_EQ(outcome.output.find("nanoweft: error: "), outcome.output.rfind("nanoweft: error: "))
      << outcome.output;
  static std::string line;
  line = outcome.output.substr(
      std::min(outcome.output.size(), outcome.output.find("nanoweft: error: ")));
  std::smatch found;
  EXPECT_TRUE(std::regex_search(
      line, found, std::regex("unstable at step ([0-9]+): fibre [0-9]+ segment [0-9]+ .*")))
      << outcome.output;
  return found;
}

TEST_P(OnRanks, UnstableRunWithoutCheckpointSaysSo) {
  const Folder folder;
  expectUnstable(run(folder, weave + "-ts_dt 80 -ts_dt_unsafe -ts_max_steps 5000", GetParam()));
  EXPECT_NE(readFile(folder / "out.txt").find("no checkpoint"), std::string::npos);
}

TEST_P(OnRanks, UnstableRunLeavesAGoodCheckpoint) {
  const Folder folder;
  const Outcome outcome =
      run(folder,
          weave +
              "-ts_dt 80 -ts_dt_unsafe -energy_alarm 0 -ts_max_steps 5000 -checkpoint_file c.h5 "
              "-checkpoint_interval 1",
          GetParam());
  const std::smatch unstable = expectUnstable(outcome);
  ASSERT_EQ(unstable.size(), 2u);
  std::smatch named;
  ASSERT_TRUE(std::regex_search(outcome.output, named,
                                std::regex("checkpoint c\\.h5 of step ([0-9]+) is good")))
      << outcome.output;
  EXPECT_LT(std::stol(named[1]), std::stol(unstable[1]));
  for (const char* name : {"position", "orientation", "velocity", "angular_velocity"})
    for (double x : readDataset(folder / "c.h5", std::string("state/") + name))
      ASSERT_TRUE(std::isfinite(x)) << name;
  const Outcome again =
      run(folder, weave + "-restart c.h5 -ts_max_steps " + named[1].str(), GetParam());
  EXPECT_EQ(again.status, 0) << again.output;
  EXPECT_NE(again.output.find("restart from c.h5 at step " + named[1].str()), std::string::npos)
      << again.output;
  expectClean(again.output);
}

/// What is called good can be gone on from: with a step that is stable, the run goes on.
TEST_P(OnRanks, CheckpointOfAnUnstableRunGoesOn) {
  const Folder folder;
  expectUnstable(run(
      folder,
      weave + "-ts_dt 80 -ts_dt_unsafe -energy_alarm 0 -ts_max_steps 5000 -checkpoint_file c.h5 "
              "-checkpoint_interval 1",
      GetParam()));
  const Outcome again =
      run(folder, weave + "-restart c.h5 -ts_dt 5 -energy_alarm 0 -ts_max_steps 200", GetParam());
  EXPECT_EQ(again.status, 0) << again.output;
}

/// Whether such a box is refused or works: it is no internal error.
TEST_P(OnRanks, HugePeriodicBoxIsNoInternalError) {
  const Folder folder;
  const Outcome outcome =
      run(folder,
          fibre + "-domain_lower -1e9,-1e9,-1e9 -domain_upper 1e9,1e9,1e9 -domain_periodic 1,1,1",
          GetParam());
  EXPECT_TRUE(outcome.status == 0 || outcome.status == 1) << outcome.status;
  expectClean(outcome.output);
}

/// A disk that fills up must not pass for a complete table.
TEST_P(OnRanks, FullDiskIsNoSuccess) {
  const Folder folder;
  EXPECT_NE(run(folder, fibre + "-energy_monitor ascii:/dev/full", GetParam()).status, 0);
}

/// Both questions that a newcomer asks first are no error.
TEST(Asking, HelpAndVersionAreNoError) {
  const Folder folder;
  const Outcome help = run(folder, "-help", 2);
  EXPECT_EQ(help.status, 0) << help.output;
  for (const char* option :
       {"-ts_dt <", "-scene <", "-weave_fibres <", "-tension_rate <", "-checkpoint_file <"})
    EXPECT_NE(help.output.find(option), std::string::npos) << option;
  EXPECT_EQ(help.output.find("nanoweft: "), help.output.rfind("nanoweft: "))
      << help.output;  // its title alone
  const Outcome version = run(folder, "-version", 2);
  EXPECT_EQ(version.status, 0) << version.output;
}

}  // namespace
