#include "fem/io/febio_file.h"

#include "mesh/base/error.h"
#include "tests/support/wounds/hooked_block.h"
#include "tests/verification/reference/febio_file_reader.h"
#include "tests/verification/reference/xml_element.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace retractor::fem {
namespace febio_file_test {

    using namespace test_support;
    using verification::first_difference;
    using verification::parse_xml;
    using verification::read_febio_file;
    using verification::XmlElement;

    TEST(FebioFile, ReadsBackToTheLastBit)
    {
        for (const int nodes_per_tet : { 4, 10 }) {
            ElasticProblem problem = test_support::hooked_block(2, nodes_per_tet);
            problem.mesh.vertices.col(0).array() += 1.0 / 3.0; // digits to the last
            problem.material_of_label[1].name = "a <\"&'> b"; // all that XML escapes
            const ElasticProblem back = read_febio_file(febio_file(problem));
            EXPECT_EQ(first_difference(problem, back), "");
            EXPECT_EQ(febio_file(problem), febio_file(back));
            EXPECT_NE(febio_file(problem).find("a &lt;&quot;&amp;&apos;&gt; b"), std::string::npos);
        }
    }

    TEST(FebioFile, AProblemWithoutBedsOrSupportsReadsBack)
    {
        ElasticProblem problem = test_support::hooked_block(2, 4);
        problem.supports = {};
        EXPECT_EQ(first_difference(problem, read_febio_file(febio_file(problem))), "");
    }

    TEST(FebioFile, HingesAreRefusedByName)
    {
        ElasticProblem problem = test_support::hooked_block(2, 4);
        EXPECT_NO_THROW((void)febio_file(problem));
        const auto nodes = problem.mesh.tet(0);
        const Vec3 along = point_at(problem.mesh.vertices, nodes[1]) - point_at(problem.mesh.vertices, nodes[0]);
        problem.supports.hinges.push_back({ .name = "rib_left_5",
            .axis = along.unitOrthogonal(),
            .stiffness = 868.0,
            .toe = 0.01,
            .edges = { { nodes[0], nodes[1], 1.0 } } });
        try {
            (void)febio_file(problem);
            FAIL();
        } catch (const InputError& error) {
            EXPECT_EQ(error.where(), "hinge of rib_left_5");
        }
    }

    TEST(FebioFile, DifferencesAreFound)
    {
        const ElasticProblem problem = test_support::hooked_block(2, 4);
        ElasticProblem other = problem;
        other.mesh.vertices(3, 1) += 1e-15 + 1e-13;
        EXPECT_EQ(first_difference(problem, other), "the vertices differ");
        other = problem;
        std::swap(other.mesh.nodes[0], other.mesh.nodes[1]);
        EXPECT_EQ(first_difference(problem, other), "the elements differ");
        other = problem;
        other.mesh.labels[0] = 2;
        EXPECT_EQ(first_difference(problem, other), "the labels differ");
        other = problem;
        other.material_of_label[2].poissons_ratio = 0.31;
        EXPECT_EQ(first_difference(problem, other), "the materials of label 2 differ");
        other = problem;
        other.supports.fixed.pop_back();
        EXPECT_EQ(first_difference(problem, other), "the fixed nodes differ");
        other = problem;
        other.supports.bedded[1].stiffness *= 2.0;
        EXPECT_EQ(first_difference(problem, other), "the beds differ");
        other = problem;
        other.hooks[1].displacement.x() = 3.0;
        EXPECT_EQ(first_difference(problem, other), "the hooks differ");
    }

    void expect_refused(std::string text, const std::string& from, const std::string& to, const std::string& word)
    {
        const std::size_t at = text.find(from);
        ASSERT_NE(at, std::string::npos) << from;
        text.replace(at, from.size(), to);
        try {
            (void)read_febio_file(text);
            ADD_FAILURE() << "accepted: " << to;
        } catch (const InputError& error) {
            EXPECT_NE((error.what() + (" " + error.where())).find(word), std::string::npos)
                << error.what() << " " << error.where();
        }
    }

    TEST(FebioFile, DamageIsRefusedByLine)
    {
        const std::string text = febio_file(test_support::hooked_block(2, 4));
        expect_refused(text, "<node id=\"1\">0,", "<node id=\"1\">zero,", "\"zero\" is not a number");
        expect_refused(text, "<node id=\"2\">", "<node id=\"7\">", "numbered from 1");
        expect_refused(text, "<elem id=\"1\">1,", "<elem id=\"1\">100000,", "no node 100000");
        expect_refused(text, "<elem id=\"1\">1,", "<elem id=\"1\">", "with all their nodes");
        expect_refused(text, "<elem id=\"2\">", "<elem id=\"1\">", "once each");
        expect_refused(text, "neo-Hookean", "Ogden", "not neo-Hookean");
        expect_refused(text, "version=\"4.0\"", "version=\"3.0\"", "version 4.0");
        expect_refused(text, "<E>0.04</E>", "<E>-0.04</E>", "");
        expect_refused(text, "node_set=\"hook1\"", "node_set=\"hook9\"", "hook9");
        expect_refused(text, "<dof>x</dof>", "<dof>w</dof>", "none of x, y, z");
        expect_refused(text, "</Boundary>", "", "is not closed");
        expect_refused(text, "</febio_spec>", "", "not well-formed");
        expect_refused(text, "<Boundary>", "<Walls/><Boundary a=b>", "no quotes");
    }

    TEST(FebioFile, TheReadersXmlIsThatOfFebiosOwnFiles)
    {
        const char* set = std::getenv("RETRACTOR_SHARED_DATA");
        const auto file = std::filesystem::path(set != nullptr ? set : RETRACTOR_SHARED_DATA_DEFAULT) / "fem" / "febio"
            / "te01.feb";
        std::ifstream in(file, std::ios::binary);
        if (!in)
            GTEST_SKIP() << "no reference file " << file << ": set RETRACTOR_SHARED_DATA";
        const XmlElement root = parse_xml(std::string { std::istreambuf_iterator<char>(in), {} });
        EXPECT_EQ(root.attribute("version"), "4.0");
        // What we write is named and nested as it is there.
        const XmlElement ours = parse_xml(febio_file(test_support::hooked_block(2, 4)));
        for (const char* section :
            { "Module", "Control", "Material", "Mesh", "MeshDomains", "Boundary", "LoadData", "Output" })
            EXPECT_EQ(root.all(section).size(), ours.all(section).size()) << section;
        for (const char* part : { "Nodes", "Elements", "NodeSet" })
            EXPECT_FALSE(root.child("Mesh").all(part).empty() || ours.child("Mesh").all(part).empty()) << part;
        const XmlElement& theirs = *root.child("Boundary").all("bc").front();
        for (const XmlElement* bc : ours.child("Boundary").all("bc")) {
            EXPECT_EQ(bc->attributes.size(), theirs.attributes.size());
            if (bc->attribute("type") == theirs.attribute("type")) {
                for (const XmlElement& dof : theirs.children)
                    EXPECT_EQ(bc->all(dof.name).size(), 1u) << dof.name;
            }
        }
    }

    TEST(Xml, EntitiesAttributesAndCommentsAreUnderstood)
    {
        const XmlElement root = parse_xml("<?xml version='1.0'?><!-- a -->\n<a b='1 &lt; 2' c=\"x\"> t<!-- > --><d/>u "
                                          "&amp;</a>\n");
        EXPECT_EQ(root.attribute("b"), "1 < 2");
        EXPECT_EQ(root.text, " tu &");
        EXPECT_EQ(root.child("d").line, 2);
        for (const char* bad : { "", "<", "<a", "<a>", "<a></b>", "<a/><b/>", "<a b=1/>", "<a b='1' b='2'/>",
                 "<a>&no;</a>", "<!-- <a/>", "<a b=\"/>", "< a/>" })
            EXPECT_THROW((void)parse_xml(bad), InputError) << bad;
        std::string deep;
        for (int i = 0; i < 100000; ++i)
            deep += "<a>";
        EXPECT_THROW((void)parse_xml(deep), InputError);
    }

} // namespace febio_file_test
} // namespace retractor::fem
