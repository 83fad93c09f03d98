/// State files that people make in ways that nobody thought of: each is read rightly or refused
/// with the reason.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <functional>
#include <limits>

#include "nanoweft/base/error.hpp"
#include "nanoweft/base/hdf5.hpp"
#include "state_helpers.hpp"

namespace nanoweft::test {
namespace {

constexpr hsize_t segments = 5;

using Shape = std::vector<hsize_t>;

void dataset(hid_t group, const char* name, hid_t type, const Shape& shape, const void* values,
             hid_t creation = H5P_DEFAULT) {
  if (H5Lexists(group, name, H5P_DEFAULT) > 0) H5Ldelete(group, name, H5P_DEFAULT);
  h5::Handle space(H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr),
                   H5Sclose);
  h5::Handle set(H5Dcreate2(group, name, type, space, H5P_DEFAULT, creation, H5P_DEFAULT),
                 H5Dclose);
  if (values) H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values);
}

template <class T>
void numbers(hid_t group, const char* name, hid_t type, std::vector<T> values,
             hsize_t columns = 1) {
  const hsize_t rows = values.size() / columns;
  dataset(group, name, type, columns == 1 ? Shape{rows} : Shape{rows, columns}, values.data());
}

void reals(hid_t group, const char* name, const std::vector<double>& values, hsize_t columns = 1) {
  numbers(group, name, H5T_NATIVE_DOUBLE, values, columns);
}

void attribute(hid_t group, const char* name, hid_t type, const Shape& shape, const void* values) {
  if (H5Aexists(group, name) > 0) H5Adelete(group, name);
  h5::Handle space(shape.empty()
                       ? H5Screate(H5S_SCALAR)
                       : H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr),
                   H5Sclose);
  h5::Handle a(H5Acreate2(group, name, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  H5Awrite(a, type, values);
}

h5::Handle textType(std::size_t size, H5T_str_t padding = H5T_STR_NULLTERM) {
  h5::Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type, size);
  H5Tset_strpad(type, padding);
  return type;
}

/// Five segments in a row, as ten lines of h5py would write them.
void make(const std::string& file, const std::function<void(hid_t f, hid_t group)>& change) {
  h5::silence();
  h5::Handle f(H5Fcreate(file.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose);
  h5::Handle g(H5Gcreate2(f, "state", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
  h5::writeAttribute(g, "format", "nanoweft-state");
  h5::writeScalar(g, "version", std::int64_t{1});
  h5::writeAttribute(g, "units", "nano");
  h5::writeAttribute(g, "lower", std::vector<double>{-99, -99, -99});
  h5::writeAttribute(g, "upper", std::vector<double>{99, 99, 99});
  h5::writeAttribute(g, "periodic", std::vector<std::int64_t>{1, 0, 0});
  std::vector<double> position, orientation;
  for (int k = 0; k < 5; ++k) {
    position.insert(position.end(), {13.56 * k, 0, 0});
    orientation.insert(orientation.end(), {1, 0, 0, 0});
  }
  reals(g, "position", position, 3);
  reals(g, "orientation", orientation, 4);
  numbers<std::int64_t>(g, "fibre", H5T_NATIVE_INT64, {3, 3, 3, 3, 3});
  numbers<std::int64_t>(g, "index", H5T_NATIVE_INT64, {0, 1, 2, 3, 4});
  change(f, g);
}

/// What is wrong with such a file, read to the end; `look` sees the state where nothing is.
std::string problemOf(const std::function<void(hid_t, hid_t)>& change,
                      const std::function<void(const State&)>& look = {}) {
  const Place place;
  make(place / "in.h5", change);
  try {
    const StateHeader header = readStateHeader(PETSC_COMM_SELF, place / "in.h5");
    State state(PETSC_COMM_SELF, header.box, {});
    readStateRows(place / "in.h5", header, state);
    EXPECT_EQ(state.owned(), 5);
    if (look) look(state);
    return "";
  } catch (const InputError& problem) {
    return problem.what();
  }
}

void expectRefused(const std::string& fragment, const std::function<void(hid_t, hid_t)>& change) {
  const std::string problem = problemOf(change);
  EXPECT_TRUE(problem.starts_with("state file ")) << problem;
  EXPECT_NE(problem.find(fragment), std::string::npos) << "no '" << fragment << "' in: " << problem;
}

void expectRead(const std::function<void(hid_t, hid_t)>& change,
                const std::function<void(const State&)>& look = {}) {
  EXPECT_EQ(problemOf(change, look), "");
}

const double notANumber = std::numeric_limits<double>::quiet_NaN(),
             infinite = std::numeric_limits<double>::infinity();

TEST(OddState, TextsOfAllKindsAreRead) {
  for (const H5T_str_t padding : {H5T_STR_NULLTERM, H5T_STR_NULLPAD, H5T_STR_SPACEPAD})
    expectRead([&](hid_t, hid_t g) {
      const std::string fill(30, padding == H5T_STR_SPACEPAD ? ' ' : '\0');
      attribute(g, "format", textType(30, padding), {}, ("nanoweft-state" + fill).c_str());
      attribute(g, "units", textType(30, padding), {1}, ("nano" + fill).c_str());
    });
  expectRead([](hid_t, hid_t g) {
    const char* text = "nano";
    attribute(g, "units", textType(H5T_VARIABLE), {}, &text);
  });
}

TEST(OddState, TextsThatAreSeveralOrNoneAreRefused) {
  for (const std::size_t size : {std::size_t{5}, std::size_t{H5T_VARIABLE}})
    expectRefused("units", [&](hid_t, hid_t g) {
      const std::vector<const char*> texts(64, "nano");
      const std::string fixed(320, 'n');
      attribute(g, "units", textType(size), {64},
                size == 5 ? static_cast<const void*>(fixed.data()) : texts.data());
    });
  expectRefused("units", [](hid_t, hid_t g) {
    attribute(g, "units", H5T_NATIVE_INT, {}, std::array<int, 1>{1}.data());
  });
  expectRefused("units", [](hid_t, hid_t g) {
    const char* none = nullptr;
    attribute(g, "units", textType(H5T_VARIABLE), {}, &none);
  });
  expectRefused("format", [](hid_t, hid_t g) { H5Adelete(g, "format"); });
}

TEST(OddState, NumbersOfTheWrongKindInAttributesAreRefused) {
  auto real = [](const char* name, std::vector<double> values) {
    return [=](hid_t, hid_t g) {
      attribute(g, name, H5T_NATIVE_DOUBLE, values.size() == 1 ? Shape{} : Shape{values.size()},
                values.data());
    };
  };
  for (const double x : {1.5, -1.0, notANumber, infinite, 1e19}) {
    SCOPED_TRACE(x);
    expectRefused("step", real("step", {x}));
  }
  expectRefused("step", real("step", {}));
  expectRefused("step", real("step", {1, 2}));
  expectRefused("time", real("time", {notANumber}));
  expectRefused("time", [](hid_t, hid_t g) { h5::writeAttribute(g, "time", "400"); });
  expectRefused("step", [](hid_t, hid_t g) { h5::writeAttribute(g, "step", "40"); });
  expectRefused("periodic", real("periodic", {0.5, 0, 0}));
  expectRefused("periodic", real("periodic", {2, 0, 0}));
  expectRefused("periodic", real("periodic", {1, 0}));
  expectRefused("lower", real("lower", {0, 0, infinite}));
  expectRefused("lower", [](hid_t, hid_t g) {
    H5Adelete(g, "lower");
    h5::writeAttribute(g, "lower", "0 0 0");
  });
  expectRefused("version", real("version", {1.25}));
  expectRead(real("step", {40.0}));
  expectRead(real("periodic", {1, 0, 0}));
  const std::uint64_t large = ~std::uint64_t{0};
  expectRefused("step",
                [&](hid_t, hid_t g) { attribute(g, "step", H5T_NATIVE_UINT64, {}, &large); });
}

TEST(OddState, DatasetsOfOtherTypesAreConvertedOrRefused) {
  expectRead([](hid_t, hid_t g) { reals(g, "index", {0, 1, 2, 3, 4}); });
  expectRead([](hid_t, hid_t g) {
    numbers<std::int8_t>(g, "index", H5T_NATIVE_INT8, {0, 1, 2, 3, 4});
  });
  expectRead(
      [](hid_t, hid_t g) {
        h5::Handle boolean(H5Tenum_create(H5T_NATIVE_INT8), H5Tclose);
        for (std::int8_t v : {0, 1}) H5Tenum_insert(boolean, v ? "TRUE" : "FALSE", &v);
        numbers<std::int8_t>(g, "bond_broken", boolean, {0, 1, 0, 0, 0});
      },
      [](const State& s) { EXPECT_EQ(s.bond[1], nextBroken); });
  expectRead(
      [](hid_t, hid_t g) {
        numbers<std::int64_t>(g, "group", H5T_NATIVE_INT64, {1, 2, 4, 8, 65535});
      },
      [](const State& s) { EXPECT_EQ(s.group[4], 65535); });
  expectRefused("row 2", [](hid_t, hid_t g) { reals(g, "index", {0, 1, 2.5, 3, 4}); });
  expectRefused("bond_broken",
                [](hid_t, hid_t g) { reals(g, "bond_broken", std::vector<double>(5, infinite)); });
  expectRefused("bond_broken", [](hid_t, hid_t g) { reals(g, "bond_broken", {0, 0, 0, 0, 7}); });
  expectRefused("group", [](hid_t, hid_t g) { reals(g, "group", {0, 0, notANumber, 0, 0}); });
  expectRefused("row 3", [](hid_t, hid_t g) {
    numbers<std::int64_t>(g, "group", H5T_NATIVE_INT64, {0, 0, 0, 1ll << 40, 0});
  });
  expectRefused("row 0", [](hid_t, hid_t g) {
    numbers<std::uint64_t>(g, "fibre", H5T_NATIVE_UINT64, std::vector(5, ~std::uint64_t{0}));
  });
  expectRefused("must hold numbers", [](hid_t, hid_t g) {
    dataset(g, "position", textType(8), {segments, 3}, std::string(120, '1').data());
  });
  expectRefused("must hold whole numbers", [](hid_t, hid_t g) {
    h5::Handle pair(H5Tcreate(H5T_COMPOUND, 16), H5Tclose);
    H5Tinsert(pair, "r", 0, H5T_NATIVE_DOUBLE);
    H5Tinsert(pair, "i", 8, H5T_NATIVE_DOUBLE);
    dataset(g, "fibre", pair, {segments}, std::vector<double>(2 * segments).data());
  });
}

TEST(OddState, ShapesThatDoNotFitAreRefused) {
  expectRefused("[N, 3]", [](hid_t, hid_t g) { reals(g, "velocity", std::vector<double>(15)); });
  expectRefused("[N]", [](hid_t, hid_t g) { reals(g, "fibre", std::vector<double>(5), 5); });
  expectRefused("[N, 3]", [](hid_t, hid_t g) { reals(g, "image", std::vector<double>(12), 3); });
  expectRefused("[N, 3]", [](hid_t, hid_t g) {
    h5::Handle space(H5Screate(H5S_NULL), H5Sclose);
    h5::Handle set(
        H5Dcreate2(g, "velocity", H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
        H5Dclose);
  });
  expectRefused("more entries than", [](hid_t, hid_t g) {
    h5::Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    const hsize_t chunk = 1024;
    H5Pset_chunk(creation, 1, &chunk);
    dataset(g, "fibre_closed", H5T_NATIVE_INT64, {hsize_t{1} << 40}, nullptr, creation);
  });
  expectRefused("not a dataset", [](hid_t, hid_t g) {
    h5::Handle group(H5Gcreate2(g, "velocity", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
  });
}

TEST(OddState, DataThatAreElsewhereOrNowhereAreRefused) {
  expectRefused("link to nothing", [](hid_t, hid_t g) {
    H5Lcreate_soft("/nowhere", g, "velocity", H5P_DEFAULT, H5P_DEFAULT);
  });
  expectRefused("another file", [](hid_t, hid_t g) {
    H5Lcreate_external("other.h5", "/v", g, "velocity", H5P_DEFAULT, H5P_DEFAULT);
  });
  expectRefused("another file", [](hid_t, hid_t g) {
    h5::Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    H5Pset_external(creation, "raw.bin", 0, H5F_UNLIMITED);
    dataset(g, "velocity", H5T_NATIVE_DOUBLE, {segments, 3}, nullptr, creation);
  });
  expectRefused("another file", [](hid_t, hid_t g) {
    const hsize_t shape[2] = {segments, 3};
    h5::Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose),
        space(H5Screate_simple(2, shape, nullptr), H5Sclose);
    H5Pset_virtual(creation, space, "other.h5", "v", space);
    dataset(g, "velocity", H5T_NATIVE_DOUBLE, {segments, 3}, nullptr, creation);
  });
  expectRefused("never written",
                [](hid_t, hid_t g) { dataset(g, "fibre", H5T_NATIVE_INT64, {segments}, nullptr); });
  // By hand, what is optional may be left at its default.
  expectRead([](hid_t, hid_t g) {
    dataset(g, "velocity", H5T_NATIVE_DOUBLE, {segments, 3}, nullptr);
  });
  expectRefused("never written", [](hid_t f, hid_t g) {
    h5::Handle run(H5Gcreate2(f, "run", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
    h5::writeScalar(g, "step", std::int64_t{0});
    h5::writeScalar(g, "time", 0.0);
    dataset(g, "velocity", H5T_NATIVE_DOUBLE, {segments, 3}, nullptr);
  });
  expectRead([](hid_t, hid_t g) {
    H5Lmove(g, "position", g, "places", H5P_DEFAULT, H5P_DEFAULT);
    H5Lcreate_soft("/state/places", g, "position", H5P_DEFAULT, H5P_DEFAULT);
  });
}

TEST(OddState, LinksThatAreElsewhereOrHalfWrittenAreRefused) {
  auto group = [](hid_t f) {
    return h5::Handle(H5Gcreate2(f, "link", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
  };
  const std::vector<std::int64_t> ends{0, 0, 0, 2};
  auto segmentsOf = [&](hid_t links) {
    dataset(links, "segments", H5T_NATIVE_INT64, {1, 2, 2}, ends.data());
  };
  expectRefused("/link/segments is a link to another file", [&](hid_t f, hid_t) {
    H5Lcreate_external("other.h5", "/s", group(f), "segments", H5P_DEFAULT, H5P_DEFAULT);
  });
  expectRefused("/link/segments must have the shape [N, 2, 2]", [&](hid_t f, hid_t) {
    dataset(group(f), "segments", H5T_NATIVE_INT64, {1, 4}, ends.data());
  });
  expectRefused("/link/segments must have the shape [N, 2, 2]", [&](hid_t f, hid_t) {
    dataset(group(f), "segments", H5T_NATIVE_INT64, {1, 2, 1}, ends.data());
  });
  expectRefused("/link/rest_length must have the shape [N]", [&](hid_t f, hid_t) {
    const auto links = group(f);
    segmentsOf(links);
    dataset(links, "rest_length", H5T_NATIVE_DOUBLE, {1, 1}, nullptr);
  });
  expectRefused("/link/rest_length was never written", [&](hid_t f, hid_t) {
    const auto links = group(f);
    segmentsOf(links);
    dataset(links, "rest_length", H5T_NATIVE_DOUBLE, {1}, nullptr);
  });
  expectRefused("/link/segments was never written, or only in part", [&](hid_t f, hid_t) {
    const hsize_t shape[3] = {2, 2, 2}, chunk[3] = {1, 2, 2}, start[3] = {0, 0, 0};
    h5::Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose),
        space(H5Screate_simple(3, shape, nullptr), H5Sclose),
        memory(H5Screate_simple(3, chunk, nullptr), H5Sclose);
    H5Pset_chunk(creation, 3, chunk);
    h5::Handle set(H5Dcreate2(group(f), "segments", H5T_NATIVE_INT64, space, H5P_DEFAULT, creation,
                              H5P_DEFAULT),
                   H5Dclose);
    H5Sselect_hyperslab(space, H5S_SELECT_SET, start, nullptr, chunk, nullptr);
    H5Dwrite(set, H5T_NATIVE_INT64, memory, space, H5P_DEFAULT, ends.data());
  });
  expectRefused("/link/kind has 0.5", [&](hid_t f, hid_t) {
    const auto links = group(f);
    segmentsOf(links);
    const double half = 0.5;
    dataset(links, "kind", H5T_NATIVE_DOUBLE, {1}, &half);
  });
}

TEST(OddState, AFilterThatIsNotThereIsNamed) {
  H5Z_class2_t filter{};
  filter.version = H5Z_CLASS_T_VERS;
  filter.id = 300;
  filter.encoder_present = filter.decoder_present = 1;
  filter.name = "squeeze";
  filter.filter = [](unsigned, std::size_t, const unsigned*, std::size_t n, std::size_t*, void**) {
    return n;
  };
  const Place place;
  ASSERT_GE(H5Zregister(&filter), 0);
  make(place / "in.h5", [](hid_t, hid_t g) {
    h5::Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    const hsize_t chunk[2] = {segments, 3};
    H5Pset_chunk(creation, 2, chunk);
    H5Pset_filter(creation, 300, H5Z_FLAG_MANDATORY, 0, nullptr);
    const std::vector<double> v(15, 0.0);
    dataset(g, "velocity", H5T_NATIVE_DOUBLE, {segments, 3}, v.data(), creation);
  });
  EXPECT_EQ(stateFileProblem(place / "in.h5"), "");
  H5Zunregister(300);
  EXPECT_NE(stateFileProblem(place / "in.h5").find("needs the HDF5 filter 300 squeeze"),
            std::string::npos)
      << stateFileProblem(place / "in.h5");
}

TEST(OddState, PhysicsOfLaterVersionsIsRefused) {
  auto group = [](const char* name) {
    return [=](hid_t f, hid_t) {
      h5::Handle(H5Gcreate2(f, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
    };
  };
  expectRefused("/link has no dataset segments", group("link"));
  expectRefused("does not know", group("contact"));
  expectRefused("its kind is 1; there are 1", [](hid_t, hid_t g) {
    reals(g, "kind", {0, 0, 1, 1, 1});
  });
  expectRead([](hid_t, hid_t g) { reals(g, "kind", std::vector<double>(5)); });
  expectRead(group("notes"));
}

TEST(OddState, ValuesThatMakeNoSenseNameTheirRow) {
  expectRefused("row 1", [](hid_t, hid_t g) {
    std::vector<double> x(15, 0.0);
    x[3] = 1e300;
    reals(g, "position", x, 3);
  });
  expectRefused("viscous", [](hid_t, hid_t g) {
    reals(g, "viscous", std::vector<double>(30, notANumber), 6);
  });
  expectRefused("fibre 4", [](hid_t, hid_t g) { reals(g, "fibre_closed", {3, 4}); });
  expectRefused("twice", [](hid_t, hid_t g) { reals(g, "fibre_closed", {3, 3}); });
  expectRead([](hid_t, hid_t g) { reals(g, "fibre_closed", {3}); },
             [](const State& s) { EXPECT_EQ(s.bond[0], fibreClosed); });
}

TEST(OddState, ThingsThatAreNoFilesAreRefusedAtOnce) {
  const Place place;
  ::mkfifo((place / "pipe").c_str(), 0666);
  std::filesystem::create_symlink("none.h5", place / "link.h5");
  auto says = [&](const std::string& file, const std::string& fragment) {
    EXPECT_NE(stateFileProblem(file).find(fragment), std::string::npos) << stateFileProblem(file);
  };
  says(place / "pipe", "it is a fifo");
  says(place / "link.h5", "a link to nothing");
  says(place / "", "it is a folder");
  says("/dev/zero", "it is a device");
  says(place / std::string(300, 'x'), "File name too long");
  setBytes(place / "empty.h5", "");
  says(place / "empty.h5", "HDF5");
  make(place / "busy.h5", [](hid_t, hid_t) {});
  const int fd = ::open((place / "busy.h5").c_str(), O_RDWR);
  ASSERT_EQ(::flock(fd, LOCK_EX), 0);
  says(place / "busy.h5", "it is locked");
  ::close(fd);
  EXPECT_EQ(stateFileProblem(place / "busy.h5"), "");
}

}  // namespace
}  // namespace nanoweft::test
