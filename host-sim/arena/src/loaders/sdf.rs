//! Bodies of a Gazebo world file (SDF): what its models collide with, from above.
//!
//! It reads upright cylinders and boxes and leaves out planes (the ground). It refuses other shapes
//! and files that include models: a world without some of its bodies would be another world.

use std::path::Path;

use roxmltree::{Document, Node};

use crate::geometry::{Point, Pose};
use crate::shapes::Shape;
use files::error::BadInput;
use files::{MAX_INPUT_BYTES, read_text};

/// The bodies of the world file at `path`.
///
/// # Errors
/// A file that cannot be read or is no SDF world, a body that cannot be taken: file and line.
pub(super) fn load(path: &Path) -> Result<Vec<Shape>, BadInput> {
    parse(
        &path.display().to_string(),
        &read_text(path, MAX_INPUT_BYTES)?,
    )
}

fn parse(source: &str, text: &str) -> Result<Vec<Shape>, BadInput> {
    let document =
        Document::parse(text).map_err(|error| BadInput::new(format!("{source}: {error}")))?;
    let file = SdfFile {
        source,
        document: &document,
    };
    let root = document.root_element();
    let world = child(root, "world").filter(|_| root.has_tag_name("sdf"));
    let world =
        world.ok_or_else(|| file.error(root, "is no world: there is no <world> in <sdf>"))?;
    if let Some(include) = child(world, "include") {
        return Err(file.error(
            include,
            "includes a model from elsewhere, which is not read",
        ));
    }
    let mut shapes = Vec::new();
    for model in children(world, "model") {
        let at = file.pose(model, Pose::default())?;
        for link in children(model, "link") {
            let at = file.pose(link, at)?;
            for collision in children(link, "collision") {
                let at = file.pose(collision, at)?;
                shapes.extend(file.shape(collision, at)?);
            }
        }
    }
    Ok(shapes)
}

fn children<'a, 'i>(node: Node<'a, 'i>, tag: &'static str) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children().filter(move |child| child.has_tag_name(tag))
}

fn child<'a, 'i>(node: Node<'a, 'i>, tag: &'static str) -> Option<Node<'a, 'i>> {
    children(node, tag).next()
}

struct SdfFile<'a, 'i> {
    source: &'a str,
    document: &'a Document<'i>,
}

impl SdfFile<'_, '_> {
    fn error(&self, node: Node<'_, '_>, what: &str) -> BadInput {
        let line = self.document.text_pos_at(node.range().start).row;
        BadInput::line(self.source, line as usize, what)
    }

    fn numbers(&self, node: Node<'_, '_>, count: usize) -> Result<Vec<f64>, BadInput> {
        let words = node.text().unwrap_or_default().split_whitespace();
        let numbers: Option<Vec<f64>> = words.map(|word| word.parse().ok()).collect();
        let numbers = numbers
            .filter(|numbers| numbers.len() == count && numbers.iter().all(|n| n.is_finite()));
        numbers.ok_or_else(|| {
            let tag = node.tag_name().name();
            self.error(node, &format!("<{tag}> must hold {count} finite numbers"))
        })
    }

    /// The pose of a node (x y z roll pitch yaw) in that of its parent, from above.
    fn pose(&self, node: Node<'_, '_>, parent: Pose) -> Result<Pose, BadInput> {
        let Some(pose) = child(node, "pose") else {
            return Ok(parent);
        };
        let numbers = self.numbers(pose, 6)?;
        let [x, y, _, roll, pitch, yaw] = numbers[..] else {
            return Ok(parent);
        };
        if roll.abs() > 1e-6 || pitch.abs() > 1e-6 {
            return Err(self.error(pose, "a body that does not stand upright cannot be taken"));
        }
        let place = parent.position + Point::new(x, y).turned(Point::unit(parent.heading));
        Ok(Pose::new(place, parent.heading + yaw))
    }

    fn shape(&self, collision: Node<'_, '_>, at: Pose) -> Result<Option<Shape>, BadInput> {
        let geometry = child(collision, "geometry");
        let body = geometry.and_then(|geometry| geometry.children().find(Node::is_element));
        let body = body.ok_or_else(|| self.error(collision, "a collision without a geometry"))?;
        let inner = |tag| {
            let missing = || self.error(body, &format!("the geometry has no <{tag}>"));
            child(body, tag).ok_or_else(missing)
        };
        match body.tag_name().name() {
            "plane" => Ok(None),
            "cylinder" => Ok(Some(Shape::Circle {
                center: at.position,
                radius: self.numbers(inner("radius")?, 1)?.into_iter().sum(),
            })),
            "box" => {
                let size = self.numbers(inner("size")?, 3)?;
                Ok(Some(Shape::Box {
                    center: at.position,
                    size: Point::new(size[0], size[1]),
                    angle: at.heading,
                }))
            }
            other => Err(self.error(
                body,
                &format!("a <{other}> cannot be taken, only cylinders and boxes"),
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn world(bodies: &str) -> String {
        format!(
            "<?xml version='1.0'?>\n<sdf version='1.6'>\n<world name='w'>\n{bodies}\n</world>\n</sdf>\n"
        )
    }

    fn model(pose: &str, geometry: &str) -> String {
        format!(
            "<model name='m'><pose>{pose}</pose><link name='l'><pose>1 0 0 0 0 0</pose><collision name='c'>\
             <geometry>{geometry}</geometry></collision></link></model>"
        )
    }

    #[test]
    fn poses_are_taken_one_in_the_other() {
        let quarter = std::f64::consts::FRAC_PI_2;
        let bodies = [
            model(
                "2 3 0.5 0 0 0",
                "<cylinder><radius>0.075</radius><length>1</length></cylinder>",
            ),
            model(
                &format!("2 3 0 0 0 {quarter}"),
                "<box><size>0.4 0.2 1</size></box>",
            ),
            model("0 0 0 0 0 0", "<plane><normal>0 0 1</normal></plane>"),
        ];
        let shapes = parse("w.world", &world(&bodies.join("\n"))).unwrap();
        let [
            Shape::Circle { center, radius },
            Shape::Box {
                center: boxed,
                size,
                angle,
            },
        ] = shapes[..]
        else {
            panic!("{shapes:?}");
        };
        assert!(center.distance(Point::new(3.0, 3.0)) < 1e-12 && radius == 0.075);
        assert!(boxed.distance(Point::new(2.0, 4.0)) < 1e-12);
        assert_eq!((size, angle), (Point::new(0.4, 0.2), quarter));
    }

    #[test]
    fn what_cannot_be_taken_is_named_with_its_line() {
        let cylinder = "<cylinder><radius>0.1</radius></cylinder>";
        for (text, why) in [
            (String::new(), "w.world: "),
            ("<sdf>\n<world>".to_owned(), "w.world: "),
            ("<robot/>".to_owned(), "line 1: is no world"),
            (
                world(&model("0 0 0 0 0", cylinder)),
                "line 4: <pose> must hold 6 finite numbers",
            ),
            (
                world(&model("0 0 0 0 0 nan", cylinder)),
                "line 4: <pose> must hold 6",
            ),
            (
                world(&model("0 0 0 1 0 0", cylinder)),
                "does not stand upright",
            ),
            (
                world(&model("0 0 0 0 0 0", "<sphere><radius>1</radius></sphere>")),
                "a <sphere> cannot be taken",
            ),
            (world(&model("0 0 0 0 0 0", "<cylinder/>")), "no <radius>"),
            (world(&model("0 0 0 0 0 0", "")), "without a geometry"),
            (
                world("<include><uri>model://sun</uri></include>"),
                "line 4: includes a model",
            ),
        ] {
            let error = parse("w.world", &text).expect_err(&text).to_string();
            assert!(error.contains(why), "{error}");
        }
    }
}
