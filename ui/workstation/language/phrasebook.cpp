#include "ui/workstation/language/phrasebook.h"

#include "mesh/base/error.h"

#include <QIODevice>
#include <QStringList>
#include <QXmlStreamReader>

#include <algorithm>
#include <optional>

namespace retractor::ui {

namespace {

    const QRegularExpression kPlace("%([1-9])");
    const QRegularExpression kWord("\\b[A-Za-z]{2,}"); // count() also counts matches that overlap
    /// A number, a name or a file stands in an open place; more words are a sentence that no phrase knows.
    constexpr int kMostWordsInAPlace = 6;
    constexpr int kMostWordsOfAName = 5; ///< in a list

    /// The phrase as a pattern; nothing in an open place ends a sentence or clause, so that a phrase does not swallow
    /// the next.
    OpenPhrase open_phrase(const QString& english, const QString& translation)
    {
        OpenPhrase phrase { .english = {}, .places = {}, .translation = translation, .source = english };
        QString pattern;
        int end = 0;
        for (auto found = kPlace.globalMatch(english); found.hasNext();) {
            const QRegularExpressionMatch place = found.next();
            pattern += QRegularExpression::escape(english.mid(end, place.capturedStart() - end));
            pattern += "((?:(?![.;] ).)+?)";
            phrase.places.push_back(place.captured(1).toInt());
            end = place.capturedEnd();
        }
        pattern += QRegularExpression::escape(english.mid(end));
        phrase.letters = english.size() - 2 * static_cast<int>(phrase.places.size());
        phrase.english = QRegularExpression(QRegularExpression::anchoredPattern(pattern));
        return phrase;
    }

    /// The translation of a phrase with open places; nothing where it is another phrase.
    std::optional<QString> filled(const Phrasebook& book, const OpenPhrase& phrase, const QString& english)
    {
        const QRegularExpressionMatch match = phrase.english.match(english);
        if (!match.hasMatch())
            return std::nullopt;
        QString text;
        int end = 0;
        for (auto found = kPlace.globalMatch(phrase.translation); found.hasNext();) {
            const QRegularExpressionMatch place = found.next();
            text += phrase.translation.mid(end, place.capturedStart() - end);
            const auto capture = std::find(phrase.places.begin(), phrase.places.end(), place.captured(1).toInt());
            if (capture == phrase.places.end())
                return std::nullopt;
            const QString given = match.captured(1 + static_cast<int>(capture - phrase.places.begin()));
            const QString said = translated(book, given);
            if (said == given && given.count(kWord) > kMostWordsInAPlace)
                return std::nullopt;
            text += said;
            end = place.capturedEnd();
        }
        return text + phrase.translation.mid(end);
    }

    QString joined_parts(const Phrasebook& book, const QStringList& parts, const QString& between)
    {
        QStringList said;
        for (const QString& part : parts)
            said += translated(book, part);
        return said.join(between).replace("。 ", "。"); // in Japanese no space follows a sentence
    }

    /// A list of names, each with a number or not: "heart 16.7 mm, aorta 18.7 mm".
    /// @returns nothing where one of them is not known
    std::optional<QString> translated_list(const Phrasebook& book, const QString& english)
    {
        static const QRegularExpression number(" -?[0-9.]+ (?:mm|%)$");
        QStringList said;
        if (english.contains("; ") || english.contains(". "))
            return std::nullopt;
        for (QString part : english.split(", ")) {
            const QRegularExpressionMatch match = number.match(part);
            const QString behind = match.captured();
            part = part.left(part.size() - behind.size()).replace('_', ' ');
            const bool may_be_a_name = part != english && part.count(kWord) <= kMostWordsOfAName && !part.contains('%');
            const QString name = may_be_a_name ? translated(book, part) : part;
            if (name == part)
                return std::nullopt;
            said += name + behind;
        }
        return said.join(QString::fromUtf8("\u3001"));
    }

    /// A sentence of several clauses: "opened by half a turn; held for 5 minutes." @returns nothing where none is known
    std::optional<QString> translated_clauses(const Phrasebook& book, QString english)
    {
        if (!english.contains("; "))
            return std::nullopt;
        const bool ends = english.endsWith('.');
        if (ends)
            english.chop(1);
        const QStringList clauses = english.split("; ");
        QStringList said;
        for (const QString& clause : clauses)
            said += translated(book, clause);
        if (said == clauses)
            return std::nullopt;
        return said.join(QString::fromUtf8("\uff1b")) + (ends ? QString::fromUtf8("\u3002") : QString());
    }

} // namespace

Phrasebook read_phrasebook(QIODevice& file)
{
    Phrasebook book;
    QXmlStreamReader xml(&file);
    QString source;
    while (!xml.atEnd()) {
        xml.readNext();
        if (!xml.isStartElement())
            continue;
        if (xml.name() == QLatin1String("source"))
            source = xml.readElementText();
        else if (xml.name() == QLatin1String("translation")) {
            const QString translation = xml.readElementText();
            if (translation.isEmpty()) // not yet translated
                continue;
            if (source.contains(kPlace))
                book.open_phrases.push_back(open_phrase(source, translation));
            else
                book.phrases.insert(source, translation);
        }
    }
    if (xml.hasError())
        throw InputError(xml.errorString().toStdString(), "line " + std::to_string(xml.lineNumber()));
    std::stable_sort(book.open_phrases.begin(), book.open_phrases.end(),
        [](const OpenPhrase& a, const OpenPhrase& b) { return a.letters > b.letters; });
    return book;
}

QString translated(const Phrasebook& book, const QString& english)
{
    if (const auto whole = book.phrases.find(english); whole != book.phrases.end())
        return *whole;
    if (!english.contains(kWord)) // a number
        return english;
    if (english.contains('\n'))
        return joined_parts(book, english.split('\n'), "\n");
    if (const auto list = translated_list(book, english)) // before a phrase takes two names for one
        return *list;
    for (const OpenPhrase& phrase : book.open_phrases)
        if (const auto text = filled(book, phrase, english))
            return *text;
    QStringList sentences;
    int begin = 0;
    for (int end = english.indexOf(". "); end >= 0; end = english.indexOf(". ", begin)) {
        sentences += english.mid(begin, end + 1 - begin);
        begin = end + 2;
    }
    if (sentences.isEmpty())
        return translated_clauses(book, english).value_or(english);
    sentences += english.mid(begin);
    return joined_parts(book, sentences, " ");
}

} // namespace retractor::ui
