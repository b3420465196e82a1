//! The HTML page with the paper's figures and the table of its claims.

use std::fmt::Write as _;

use crate::paper::claims::{Claim, ClaimVerdict};

use plots::draw::svg::escape;
use plots::page::{CLOSING, Figure, commands, opening, picture};

/// Builds the page. It refers to the picture files by name only; it supports dark mode, small
/// screens and print.
#[must_use]
pub fn paper_html(
    title: &str,
    about: &[String],
    claims: &[Claim],
    figures: &[Figure],
    next: &[&str],
) -> String {
    let mut html = opening(title);
    for paragraph in about {
        let _ = writeln!(html, "<p>{}</p>", escape(paragraph));
    }
    count(&mut html, claims);
    for figure in figures {
        picture(&mut html, "", figure);
    }
    table(&mut html, claims);
    commands(&mut html, next);
    html.push_str(CLOSING);
    html
}

const fn class(verdict: ClaimVerdict) -> &'static str {
    match verdict {
        ClaimVerdict::Holds => "holds",
        ClaimVerdict::Partly => "partly",
        ClaimVerdict::DoesNotHold => "not",
        ClaimVerdict::NotTestable => "untestable",
    }
}

/// Number of claims by verdict.
fn count(html: &mut String, claims: &[Claim]) {
    html.push_str("<ul class=\"count\">\n");
    for verdict in ClaimVerdict::ALL {
        let has = |claim: &&Claim| claim.verdict == verdict;
        let count = claims.iter().filter(has).count();
        let words = match (verdict, count) {
            (ClaimVerdict::NotTestable, _) | (_, 1) => verdict.words(),
            (ClaimVerdict::Holds, _) => "hold",
            (ClaimVerdict::Partly, _) => "hold partly",
            (ClaimVerdict::DoesNotHold, _) => "do not hold",
        };
        let class = class(verdict);
        let _ = writeln!(
            html,
            "<li class=\"verdict {class}\"><span>{count} {words}</span></li>"
        );
    }
    html.push_str("</ul>\n");
}

fn table(html: &mut String, claims: &[Claim]) {
    html.push_str(
        "<section>\n<h2>Claim by claim</h2>\n<table class=\"claims\">\n<thead><tr><th scope=\"col\">where</th>\
         <th scope=\"col\">claim</th><th scope=\"col\">holds if</th><th scope=\"col\">measured</th>\
         <th scope=\"col\">verdict</th></tr></thead>\n<tbody>\n",
    );
    for claim in claims {
        let place = claim.place();
        let [section, words, rule, measured, sample] = [
            &place,
            claim.words,
            &claim.rule,
            &claim.measured,
            &claim.sample,
        ]
        .map(escape);
        let of = if sample.is_empty() {
            sample
        } else {
            format!("<span class=\"of\">{sample}</span>")
        };
        let rule = if rule.is_empty() {
            "<td></td>".to_owned()
        } else {
            format!("<td data-label=\"holds if\">{rule}</td>")
        };
        let _ = writeln!(
            html,
            "<tr><td>{section}</td><td>“{words}”</td>{rule}<td data-label=\"measured\">{measured}{of}</td>\
             <td class=\"verdict {}\"><span>{}</span></td></tr>",
            class(claim.verdict),
            claim.verdict.words()
        );
    }
    html.push_str("</tbody>\n</table>\n</section>\n");
}

#[cfg(test)]
mod tests {
    use super::*;

    fn claim(words: &'static str, verdict: ClaimVerdict) -> Claim {
        Claim {
            section: "2.3",
            words,
            rule: String::new(),
            measured: "1 < 2".to_owned(),
            sample: "3 & 4".to_owned(),
            verdict,
        }
    }

    #[test]
    fn every_claim_is_counted_and_escaped() {
        let claims = [
            claim("<a>", ClaimVerdict::Holds),
            claim("b", ClaimVerdict::DoesNotHold),
            claim("c", ClaimVerdict::DoesNotHold),
        ];
        let html = paper_html("T", &["about".to_owned()], &claims, &[], &[]);
        for part in [
            "<span>1 holds</span>",
            "<span>0 hold partly</span>",
            "<span>2 do not hold</span>",
            "“&lt;a&gt;”",
            "<p>about</p>",
        ] {
            assert_eq!(html.matches(part).count(), 1, "{part} in {html}");
        }
        assert_eq!(
            html.matches("1 &lt; 2<span class=\"of\">3 &amp; 4").count(),
            3
        );
        assert_eq!(html.matches("§ 2.3").count(), 3);
    }
}
