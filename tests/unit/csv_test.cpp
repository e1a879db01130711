#include "tools/csv.h"

#include "core/error.h"

#include <gtest/gtest.h>

namespace lightgrid {
namespace {

CsvTable table(const std::string& text) {
    return CsvTable(text, "points.csv");
}

std::string complaint(const std::string& text) {
    try {
        static_cast<void>(to_points(table(text)));
    } catch (const Error& error) {
        EXPECT_EQ(error.fault(), Fault::input);
        return error.what();
    }
    return "nothing";
}

TEST(Csv, FindsColumnsByNameInAnyOrder) {
    const Points points = to_points(table("name,z,x,y\nlamp,3,1,2\ndoor,6,4,5\n"));
    ASSERT_EQ(points.positions.size(), 2U);
    EXPECT_EQ(points.positions[0], glm::dvec3(1, 2, 3));
    EXPECT_EQ(points.positions[1], glm::dvec3(4, 5, 6));
    EXPECT_TRUE(points.normals.empty());
}

TEST(Csv, ReadsNormalsWhereThereAreSome) {
    const Points points = to_points(table("x,y,z,nx,ny,nz\n0,0,0,0,-2,0\n"));
    ASSERT_EQ(points.normals.size(), 1U);
    EXPECT_EQ(points.normals[0], glm::dvec3(0, -2, 0));
    EXPECT_EQ(unit_normal(points.normals[0]), glm::vec3(0, -1, 0));
    EXPECT_EQ(unit_normal({0, 1e-300, 0}), glm::vec3(0, 1, 0));
    EXPECT_EQ(unit_normal({-1e300, 0, 0}), glm::vec3(-1, 0, 0));
}

TEST(Csv, TakesWhatSpreadsheetsAndEditorsWrite) {
    const std::vector<std::string> same{
        "x,y,z\n1,2,3\n",
        "x,y,z\n1,2,3",                                   // no end of line at the end
        "x,y,z\r\n1,2,3\r\n",                             // Windows
        "\xEF\xBB\xBFx,y,z\n1,2,3\n",                     // a byte order mark
        " x , y,\tz \n  1 ,2 ,\t3\n",                     // spaces
        "\"x\",\"y\", \"z\"\n\"1\",\"2\" , \"3\"\n",      // quotes
        "\n\nx,y,z\n\n  \n1,2,3\n\r\n",                   // blank lines
        "x,y,z,\"a \"\"b\"\", c\"\n1,2,3,\"one,two\"\n",  // commas and quotes in quotes
        "x,y,z,\n1,2,3,\n",                               // a comma too many on every line
        "x,y,z\n+1,2e0,0.3E+1\n",                         // ways to write a number
    };
    for (const std::string& text : same) {
        const Points points = to_points(table(text));
        ASSERT_EQ(points.positions.size(), 1U) << text;
        EXPECT_EQ(points.positions[0], glm::dvec3(1, 2, 3)) << text;
    }
}

TEST(Csv, KeepsEveryRowAndEveryBit) {
    const Points points = to_points(table("x,y,z\n0.1,-1e-300,123456.789012345\n0.1,-1e-300,123456.789012345\n"));
    ASSERT_EQ(points.positions.size(), 2U);
    EXPECT_EQ(points.positions[1], glm::dvec3(0.1, -1e-300, 123456.789012345));
}

TEST(Csv, MayHaveNoRows) {
    EXPECT_TRUE(to_points(table("x,y,z\n")).positions.empty());
}

TEST(Csv, NamesTheLineOfWhatIsWrong) {
    EXPECT_EQ(complaint("x,y,z\n1,2,3\n\n1,abc,3\n"), "points.csv: line 4: column y: \"abc\" is not a number");
    EXPECT_EQ(complaint("x,y,z\n1,2,\n"), "points.csv: line 2: column z: \"\" is not a number");
    EXPECT_EQ(complaint("x,y,z\n , ,\n"), "points.csv: line 2: column x: \"\" is not a number");
    EXPECT_EQ(complaint("x,y,z\n1,2,3m\n"), "points.csv: line 2: column z: \"3m\" is not a number");
    EXPECT_EQ(complaint("x,y,z\n1,+-2,3\n"), "points.csv: line 2: column y: \"+-2\" is not a number");
    EXPECT_EQ(complaint("x,y,z\nnan,2,3\n"), "points.csv: line 2: column x: \"nan\" is not finite");
    EXPECT_EQ(complaint("x,y,z\n1,-inf,3\n"), "points.csv: line 2: column y: \"-inf\" is not finite");
    EXPECT_EQ(complaint("x,y,z\n1,2,1e999\n"), "points.csv: line 2: column z: \"1e999\" is out of range");
    EXPECT_EQ(complaint("x,y,z\n1,2\n"), "points.csv: line 2: 2 fields, but the header names 3");
    EXPECT_EQ(complaint("x,y,z\n1,2,3,4\n"), "points.csv: line 2: 4 fields, but the header names 3");
    EXPECT_EQ(complaint("x,y,z\n1,2,\"3\n"), "points.csv: line 2: a quote is not closed or text follows it");
    EXPECT_EQ(complaint("x,y,z,nx,ny,nz\n1,2,3,0,0,0\n"), "points.csv: line 2: the normal is zero");
    EXPECT_EQ(complaint("x,y,z,x\n1,2,3,4\n"), "points.csv: line 1: column \"x\" is named twice");
}

TEST(Csv, ListsTheColumnsWhereOneIsMissing) {
    EXPECT_EQ(
        complaint("x;y;z\n1;2;3\n"),
        "points.csv: has no column \"x\", only x;y;z. The first line has to name the columns, separated by commas.");
    EXPECT_EQ(
        complaint("x,y,z,nx,nz\n1,2,3,0,1\n"),
        "points.csv: has no column \"ny\", only x, y, z, nx, nz. The first line has to name the columns, separated "
        "by commas.");
    EXPECT_EQ(complaint("1,2,3\n").substr(0, 43), "points.csv: has no column \"x\", only 1, 2, 3");
}

TEST(Csv, RefusesWhatIsNoText) {
    EXPECT_EQ(complaint(""), "points.csv: is empty. Its first line has to name the columns, as in x,y,z.");
    EXPECT_EQ(complaint(std::string("\x76\x2f\x31\x01\0\0", 6)),
              "points.csv: is not a text file. A CSV file is needed.");
}

TEST(CsvWriter, WritesTheShortestTextThatReadsBack) {
    testing::internal::CaptureStdout();
    CsvWriter out({"a", "b", "c", "d", "e"});
    out << 0.1 << 0.1F << glm::vec3(1, 1.0F / 3, 1e-30F);
    out.end_row();
    out.finish();
    std::fflush(stdout);
    EXPECT_EQ(testing::internal::GetCapturedStdout(), "a,b,c,d,e\n0.1,0.1,1,0.33333334,1e-30\n");
}

TEST(CsvWriter, NamesCoefficientsAsEveryVerbDoes) {
    std::vector<std::string> columns{"x"};
    add_sh_columns(columns, 'e', 2);
    EXPECT_EQ(columns, (std::vector<std::string>{"x", "e0r", "e0g", "e0b", "e1r", "e1g", "e1b", "e2r", "e2g", "e2b",
                                                 "e3r", "e3g", "e3b"}));
}

}  // namespace
}  // namespace lightgrid
