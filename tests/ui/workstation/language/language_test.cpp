// The window in Japanese: phrases with open places, the file of translations, and what a surgeon reads first.

#include "ui/workstation/language/language.h"

#include "tests/support/synthetic_patient.h"
#include "tests/support/window/window_help.h"

#include "mesh/base/error.h"
#include "planner/decision/decisions.h"
#include "planner/measures/metric_table.h"
#include "planner/measures/ranking.h"
#include "planner/measures/verdict.h"
#include "ui/plan_scene/field_map.h"
#include "ui/scene/scene.h"
#include "ui/workstation/language/phrasebook.h"
#include "ui/workstation/language/stage_words.h"
#include "ui/workstation/language/translated_page.h"
#include "ui/workstation/main_window.h"
#include "ui/workstation/planning/search_dialog.h"

#include <gtest/gtest.h>

#include <QAbstractButton>
#include <QAction>
#include <QBuffer>
#include <QComboBox>
#include <QFile>
#include <QLabel>
#include <QMenu>
#include <QRegularExpression>
#include <QTest>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <set>
#include <utility>
#include <vector>

namespace retractor::ui {
namespace language_test {

    Phrasebook book_of(const std::vector<std::pair<QString, QString>>& phrases)
    {
        QString text = "<TS version=\"2.1\"><context><name>Retractor</name>";
        for (const auto& [english, other] : phrases)
            text += "<message><source>" + english.toHtmlEscaped() + "</source><translation>" + other.toHtmlEscaped()
                + "</translation></message>";
        text += "</context></TS>";
        QByteArray bytes = text.toUtf8();
        QBuffer file(&bytes);
        file.open(QIODevice::ReadOnly);
        return read_phrasebook(file);
    }

    TEST(Phrasebook, ListsHaveNamesWithSharesAndAnAndBeforeTheLast)
    {
        const Phrasebook book = book_of({ { "skin", "S" }, { "left rib %1", "L%1" }, { "fat and muscle", "FM" },
            { "The rest is hidden by %1.", "H: %1" }, { "%1 is thick", "T: %1" } });
        EXPECT_EQ(translated(book, "skin and left rib 4"), QString::fromUtf8("S、L4"));
        EXPECT_EQ(translated(book, "The rest is hidden by skin (17 %), left rib 4 (13 %) and left rib 5 (3 %)."),
            QString::fromUtf8("H: S (17 %)、L4 (13 %)、L5 (3 %)"));
        EXPECT_EQ(translated(book, "skin, fat and muscle"), QString::fromUtf8("S、FM")) << "a name with an and";
        EXPECT_EQ(translated(book, "skin and glue"), "skin and glue") << "not all of it is known";
        EXPECT_EQ(translated(book, "27 to 33 mm is thick"), QString::fromUtf8("T: 27 〜 33 mm"));
        EXPECT_EQ(translated(book, "3 of 4"), "3 / 4");
        EXPECT_EQ(translated(book, "1 to many"), "1 to many");
    }

    TEST(StageWords, AreThoseOfASurgeon)
    {
        EXPECT_EQ(stage_in_words("refine tetrahedra"), "building the model of the wall");
        EXPECT_EQ(stage_in_words("opening, four-node elements"), "opening: first estimate");
        EXPECT_EQ(stage_in_words("read CT"), "read CT"); // plain already
        EXPECT_EQ(stage_in_words(""), "");
        // Each has a Japanese phrase.
        QFile file(":/language/ja.ts");
        ASSERT_TRUE(file.open(QIODevice::ReadOnly));
        const Phrasebook book = read_phrasebook(file);
        for (const auto& [stage, words] : stages_and_words())
            EXPECT_TRUE(book.phrases.contains(QString::fromUtf8(words.data(), static_cast<int>(words.size()))))
                << words;
        EXPECT_EQ(translated(book, "Preparing the wall for cutting: building the model of the wall 30 %"),
            QString::fromUtf8("体壁の切開を準備しています：体壁のモデルを作成中 30 %"));
        EXPECT_EQ(translated(book, "Preparing the tissue: making the organ palpable 30 %"),
            QString::fromUtf8("組織を準備しています：臓器を触診できるようにしています 30 %"));
        // Of the forecast of a plan the time stays.
        const std::string forecast = " (about 81,000 tetrahedra, about 120 s, 2.6 GiB)";
        const std::string words = stage_in_words("refine tetrahedra" + forecast);
        EXPECT_EQ(words, "building the model of the wall (about 120 s)");
        EXPECT_EQ(stage_in_words("refine tetrahedra (soon)"), "building the model of the wall");
        EXPECT_EQ(
            translated(book, QString::fromStdString(words)), QString::fromUtf8("体壁のモデルを作成中（約 120 秒）"));
    }

    TEST(Phrasebook, TranslatesThePagesTextAndNothingElse)
    {
        const Phrasebook book = book_of({ { "Stiffness & force", "Steife und Kraft" }, { "target", "Ziel" },
            { "Shows %1 % of the %2.", "Vom %2 sind %1 % zu sehen." } });
        const std::string page
            = "<!doctype html>\n<html lang=\"en\"><head><style>p { target: 1 }</style>\n"
              "<script>const t = \"target\"; if (1 < 2) f(\"<p>target</p>\");</script></head>"
              "<body title=\"target\"><h1> Stiffness &amp; force </h1><p>Shows 3 % of the\n target.</p>"
              "<p>not known: a &lt; b</p><td>target</td></body></html>\n";
        EXPECT_EQ(translated_page(book, page, "de"),
            "<!doctype html>\n<html lang=\"de\"><head><style>p { target: 1 }</style>\n"
            "<script>const t = \"target\"; if (1 < 2) f(\"<p>target</p>\");</script></head>"
            "<body title=\"target\"><h1> Steife und Kraft </h1><p>Vom Ziel sind 3 % zu sehen.</p>"
            "<p>not known: a &lt; b</p><td>Ziel</td></body></html>\n");
        EXPECT_EQ(translated_page(book, "", "de"), "");
        EXPECT_EQ(translated_page(book, "<p", "de"), "<p") << "a page that was cut off";
        EXPECT_EQ(translated_page(book, "<script>target", "de"), "<script>target");
    }

    TEST(Phrasebook, TranslatesListsOfNamesOnAPage)
    {
        const Phrasebook book
            = book_of({ { "heart", "Herz" }, { "vena cava", "Hohlvene" }, { "Held: %1.", "Haelt %1." } });
        EXPECT_EQ(translated_page(book,
                      "<td>heart 16.7 mm, vena_cava 24.8 mm</td><p>: Held: heart.</p><p>3 &plusmn; 1 hat</p>", "de"),
            "<td>Herz 16.7 mm\u3001Hohlvene 24.8 mm</td><p>: Haelt Herz.</p><p>3 &plusmn; 1 hat</p>");
        EXPECT_EQ(translated_page(book, "<td>heart, spleen</td>", "de"), "<td>heart, spleen</td>");
    }

    TEST(Phrasebook, TranslatesClauseByClause)
    {
        const Phrasebook book = book_of({ { "opens %1 mm", "weitet %1 mm" }, { "%1 blade", "%1 Blatt" },
            { "left", "linkes" }, { "the left blade lies %1 mm off", "linkes Blatt %1 mm daneben" } });
        EXPECT_EQ(translated(book, "opens 3 mm; left blade"), "weitet 3 mm\uff1blinkes Blatt");
        EXPECT_EQ(translated(book, "opens 3 mm; left blade."), "weitet 3 mm\uff1blinkes Blatt\u3002");
        EXPECT_EQ(translated(book, "opens 3 mm; unknown"), "weitet 3 mm\uff1bunknown");
        EXPECT_EQ(translated(book, "one; two"), "one; two");
        EXPECT_EQ(
            translated(book, "the left blade lies 2 mm off; opens 3 mm"), "linkes Blatt 2 mm daneben\uff1bweitet 3 mm")
            << "a place holds no two clauses";
    }

    TEST(Phrasebook, AListIsNoPlaceOfAPhraseForOneName)
    {
        const Phrasebook book = book_of({ { "left rib %1", "linke Rippe %1" }, { "heart", "Herz" } });
        EXPECT_EQ(translated(book, "left rib 4, left rib 5"), "linke Rippe 4\u3001linke Rippe 5");
        EXPECT_EQ(translated(book, "heart 2.5 mm, left rib 5 3 mm"), "Herz 2.5 mm\u3001linke Rippe 5 3 mm");
        const Phrasebook more = book_of({ { "the %1", "%1" }, { "Score %1", "Punkte %1" },
            { "Score %1, the highest", "Punkte %1, am meisten" }, { "blade: %1", "Blatt: %1" } });
        EXPECT_EQ(translated(more, "Score 12, the highest"), "Punkte 12, am meisten");
        const QString half = "blade: 70.6 N and 2.03 N m, the lip follows within 5.8 mm of it";
        EXPECT_EQ(translated(more, half), half);
    }

    TEST(Phrasebook, TranslatesReasonsThatAreJoined)
    {
        const Phrasebook book
            = book_of({ { "not cut over %1 mm: %2", "%1 mm nicht: %2" }, { "it is held", "gehalten" } });
        EXPECT_EQ(translated(book, "not cut over 3 mm: it is held"), "3 mm nicht: gehalten");
        EXPECT_EQ(translated(book, "not cut over 3 mm: it is held; it is far"), "3 mm nicht: gehalten\uff1bit is far");
        EXPECT_EQ(translated(book, "not cut over 3 mm: it is held."), "3 mm nicht: gehalten\u3002");
    }

    TEST(JapaneseReport, IsKnownInItsSentences)
    {
        QFile file(":/language/ja.ts");
        ASSERT_TRUE(file.open(QIODevice::ReadOnly));
        const Phrasebook book = read_phrasebook(file);
        for (const char* english : { "Planned surgical fields", "Research software, not a medical device.",
                 "Force 51 N; mesh: +- 33 N; tissue values: 38 to 71 N; decided by muscle, intercostal.",
                 "From the jugular notch 4 mm to its start and 197 mm to its end, in a straight line.",
                 "The joint with the spine that bears most is that of rib 5 on the left, with 6 N and 0.0 N m.",
                 "Hooks are rigid blades that bear on bone close behind them." })
            EXPECT_FALSE(translated(book, english).contains(QRegularExpression("[A-Za-z]{4}"))
                && translated(book, english) == english)
                << english;
        for (const char* english :
            { "left blade: 70.6 N and 2.03 N m, turned -3.0 degrees (the end of its play), the lip "
              "follows within 5.8 mm, pressure 152 kPa on average and 356 kPa at most (start), 37, "
              "14 and 20 N on its first, middle and last third along the incision; the frame has "
              "tilted by 1.4 degrees, and 1.3 N of its blade forces are not balanced",
                "the left lip lies up to 5.8 mm (mean 3.6 mm) off the line of its blade, most 102 mm along the "
                "incision; the right lip lies up to 7.8 mm (mean 4.8 mm) off the line of its hooks, most 9 mm along "
                "the incision",
                "largest strain, averaged over balls of 5 mm radius: muscle 77 % 206 mm along the incision, 1 mm "
                "beside "
                "it and 15 mm deep; skin 51 % 2 mm before the start of the incision, 0 mm beside it and 3 mm deep",
                "contact: the wall sinks up to 3.6 mm into the heart, which gives way; surfaces that overlap by up to "
                "2.66 mm "
                "at rest keep this overlap.",
                "right blade: 70.6 N and 2.03 N m, turned -3.0 degrees, the lip follows within 5.8 mm",
                "contact: the wall sinks up to 3.6 mm into the heart, which gives way.",
                "The best eye sees 51 % of what an eye would see of the aneurysm with the wall removed. Both eyes with "
                "a "
                "lamp see 48 %. Two instruments reach 49 %. A finger ends 31 mm before the aneurysm. What stays hidden "
                "is its anterior, superior and right part. The rest is hidden by right blade (17 %), pulmonary artery "
                "(13 %), left lung deflated (11 %) and skin (10 %).",
                "cortex of 13.5 GPa [2013] over 26 % of the section, median of 20 sections in the CT",
                "Rib 4 on the left would break in its posterior part, 110 mm from the spine, from an opening of about "
                "23 "
                "mm on (2.6 N m; tested ribs broke at about 2.0 N m). The largest opening without a fracture is about "
                "23 mm (estimate).",
                "The blades bear on soft tissue only, on no bone." })
            EXPECT_FALSE(translated(book, english).contains(QRegularExpression("[A-Za-z]{4}"))) << english;
    }

    TEST(Phrasebook, APageThatCannotBeReadIsNamed)
    {
        EXPECT_THROW(translate_page("/no/such/page.html", {}, "de"), IoError);
    }

    TEST(Phrasebook, KnowsPhrasesAndFillsOpenPlacesInTheOrderOfTheOtherLanguage)
    {
        const Phrasebook book = book_of({ { "Open", "Offen" }, { "aneurysm", "Aneurysma" },
            { "Shows %1 % of the %2.", "Vom %2 sind %1 % zu sehen." }, { "The %1 is not seen.", "%1 ist verdeckt." } });
        EXPECT_EQ(translated(book, "Open"), "Offen");
        EXPECT_EQ(translated(book, "Shows 35.0 % of the aneurysm."), "Vom Aneurysma sind 35.0 % zu sehen.");
        EXPECT_EQ(translated(book, "Shows 35 % of the hernia."), "Vom hernia sind 35 % zu sehen.");
        EXPECT_EQ(translated(book, "open"), "open") << "what is not known stays English";
        EXPECT_EQ(translated(book, ""), "");
    }

    TEST(Phrasebook, TranslatesLineByLineAndSentenceBySentence)
    {
        const Phrasebook book = book_of(
            { { "Shows %1.", "Zeigt %1." }, { "Opens %1 mm.", "Weitet %1 mm." }, { "undone", "aufgehoben" } });
        EXPECT_EQ(translated(book, "Shows 1. Opens 2 mm."), "Zeigt 1. Weitet 2 mm.");
        EXPECT_EQ(translated(book, "Opens 2.5 mm.\nundone"), "Weitet 2.5 mm.\naufgehoben");
        EXPECT_EQ(translated(book, "Shows 1. What is this?"), "Zeigt 1. What is this?");
    }

    TEST(Phrasebook, PrefersThePhraseThatSaysMostAndFillsNoPlaceWithASentence)
    {
        const Phrasebook book
            = book_of({ { "%1 is lost", "%1 fehlt" }, { "the plan of %1 is lost", "Plan %1 fehlt" } });
        EXPECT_EQ(translated(book, "the plan of A is lost"), "Plan A fehlt");
        const QString sentence = "what was drawn and then cut on the skin of it is lost";
        EXPECT_EQ(translated(book, sentence), sentence) << "half a translation is worse than none";
    }

    TEST(Phrasebook, ADamagedFileIsNamedWithItsLine)
    {
        QByteArray bytes = "<TS>\n<message><source>Open</source>\n<translation>";
        QBuffer file(&bytes);
        file.open(QIODevice::ReadOnly);
        try {
            read_phrasebook(file);
            FAIL() << "read";
        } catch (const InputError& error) {
            EXPECT_EQ(error.where(), "line 3");
        }
    }

    bool is_japanese(const QString& text)
    {
        static const QRegularExpression letters("[\\p{Hiragana}\\p{Katakana}\\p{Han}]");
        return text.contains(letters);
    }

    /// Words that a Japanese text needs: more than a unit, a key or a name.
    bool needs_translation(const QString& text)
    {
        static const QRegularExpression word("[a-z]{3,}");
        static const QRegularExpression names("(Retractor|English|case\\.json|median|straight|target|\\.png)");
        QString rest = text;
        return rest.remove(names).contains(word) && !is_japanese(text);
    }

    /// Every text of the window and of what lies in it that stays English.
    std::set<std::string> english_texts(QWidget& window)
    {
        std::set<std::string> found;
        const auto look = [&](const QString& text) {
            if (needs_translation(text))
                found.insert(text.toStdString());
        };
        for (QWidget* const widget : window.findChildren<QWidget*>()) {
            look(widget->toolTip());
            if (const auto* const label = qobject_cast<QLabel*>(widget))
                look(label->text());
            if (const auto* const button = qobject_cast<QAbstractButton*>(widget))
                look(button->text());
            if (const auto* const menu = qobject_cast<QMenu*>(widget))
                look(menu->title());
            if (const auto* const box = qobject_cast<QComboBox*>(widget); box != nullptr && !box->isEditable())
                for (int i = 0; i < box->count(); ++i)
                    look(box->itemText(i));
        }
        for (const QAction* const action : window.findChildren<QAction*>()) {
            look(action->text());
            look(action->toolTip());
        }
        return found;
    }

    std::string listed(const std::set<std::string>& texts)
    {
        std::string all;
        for (const std::string& text : texts)
            all += "\n  " + text;
        return all;
    }

    /// What stays English in a text that is composed of several parts, but for units and what people name.
    QString english_in(const std::string& text)
    {
        QString said = translated(text);
        static const QRegularExpression words("[A-Za-z]{3,}");
        return said.contains(words) ? said : QString();
    }

    class Japanese : public testing::Test {
    protected:
        Japanese() { set_language("ja"); }
        ~Japanese() override { set_language("en"); }
    };

    TEST_F(Japanese, EveryPlaceOfAPhraseIsInItsTranslation)
    {
        QFile file(":/language/ja.ts");
        ASSERT_TRUE(file.open(QIODevice::ReadOnly));
        const Phrasebook book = read_phrasebook(file);
        EXPECT_GT(book.phrases.size() + static_cast<int>(book.open_phrases.size()), 900);
        for (const OpenPhrase& phrase : book.open_phrases) {
            QString english = phrase.source, japanese = phrase.translation;
            for (const int place : phrase.places) {
                english.replace("%" + QString::number(place), QString::number(10 + place));
                japanese.replace("%" + QString::number(place), QString::number(10 + place));
            }
            EXPECT_EQ(translated(book, english), japanese)
                << "another phrase takes its place: " << english.toStdString();
            for (const int place : phrase.places)
                EXPECT_TRUE(phrase.translation.contains("%" + QString::number(place)))
                    << phrase.english.pattern().toStdString();
            EXPECT_EQ(phrase.translation.count(QRegularExpression("%[1-9]")), static_cast<int>(phrase.places.size()))
                << phrase.english.pattern().toStdString();
        }
    }

    TEST_F(Japanese, MeasuresCriteriaMapsAndQuestionsAreTranslated)
    {
        std::vector<std::string> texts;
        for (const planner::MetricField& metric : planner::metric_fields())
            texts.insert(texts.end(), { metric.caption, metric.meaning });
        for (const planner::Criterion& criterion : planner::criteria())
            texts.insert(texts.end(), { criterion.caption, criterion.meaning });
        for (const FieldMapName& map : kFieldMaps)
            texts.emplace_back(map.words);
        for (const planner::Question& question : planner::kQuestions)
            texts.insert(texts.end(), { question.title, question.sentence });
        for (const std::string& text : texts)
            EXPECT_TRUE(is_japanese(translated(text))) << text;
    }

    TEST_F(Japanese, SentencesOfTheLibrariesAreTranslatedWhole)
    {
        planner::FieldMetrics field;
        field.target = "aneurysm";
        field.mechanics_status = "converged";
        field.seen_best_eye = 0.35;
        field.opening_width_mm = 45.0;
        field.hook_force_N = 70.0;
        field.at_risk = { { .name = "aorta", .distance_mm = 0.0 } };
        field.estimated = { "aorta" };
        for (const std::string& sentence : planner::verdict_of(field).sentences)
            EXPECT_EQ(english_in(sentence), "") << sentence;
        for (const char* const text : { "With lungs of 30 % of their volume, B shows most (35 %), not A (30 %).",
                 "The sternum would break from 20 mm on.", "Rib 4 on the left would break from 30 mm on.",
                 "Here the tissue is under no tension, in the plan under 4 % tension: the wound opens differently",
                 "taking off the upper blade 2", "moving the hook 1", "hook 1 has lost its tissue and was removed",
                 "The aorta is cut. Sternum is sawn through." })
            EXPECT_EQ(english_in(text), "") << text;
    }

    TEST_F(Japanese, TheWindowAndItsDialogsSpeakIt)
    {
        const auto control = std::make_shared<test_support::SyntheticControl>();
        MainWindow window([control](const planner::Case&) { return test_support::synthetic_backend(control); });
        test_support::show_window(window);
        EXPECT_EQ(listed(english_texts(window)), "") << "on the start page";
        window.open(test_support::synthetic_case());
        test_support::wait_until_idle(window);
        QTest::keyClick(&window, Qt::Key_P);
        test_support::wait_until_idle(window);
        EXPECT_EQ(listed(english_texts(window)), "") << "with a planned case";
        QTest::keyClick(&window, Qt::Key_F, Qt::ControlModifier);
        ASSERT_NE(window.search_dialog(), nullptr);
        EXPECT_EQ(listed(english_texts(*window.search_dialog())), "");
        window.search_dialog()->close();
        const char* const folder = std::getenv("RETRACTOR_PICTURES");
        const std::filesystem::path pictures = folder != nullptr ? folder : std::filesystem::temp_directory_path();
        window.save_screenshot(pictures / "japanese.png");
    }

    TEST_F(Japanese, ThePictureIsTitledInIt)
    {
        Scene scene { .title = "Median sternotomy: through the incision" };
        translate_texts(scene);
        if (scene.title == "Median sternotomy: through the incision")
            GTEST_SKIP() << "SKIPPED: no font with Japanese letters (Debian package fonts-noto-cjk)";
        EXPECT_EQ(scene.title, "胸骨正中切開：切開からの眺め");
        const TextLanguage language = picture_language(); // what pictures of reports and movies are drawn with
        for (const char* english :
            { "Median sternotomy: opened", "target: aneurysm", "seen by the best eye", "retractor force, one side",
                "bone in sight", "sternum and 4 more", "20 to 40 %", "below 10 mm", "nearest to the cut, at rest" })
            EXPECT_FALSE(QString::fromStdString(said(language, english)).contains(QRegularExpression("[A-Za-z]{3}")))
                << english;
    }

    TEST(Language, AnUnknownOneIsRefused)
    {
        EXPECT_THROW(set_language("tlh"), InputError);
        EXPECT_EQ(language(), "en");
    }

} // namespace language_test
} // namespace retractor::ui
