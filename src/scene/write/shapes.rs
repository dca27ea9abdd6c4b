use super::super::description::{Instance, Part, ShapeGroup, Solid};
use super::super::plugins::shapes;
use super::super::read::{Class, solids};
use super::{Node, Writer};
use std::rc::Rc;
use std::sync::Arc;

pub(super) fn instance(writer: &mut Writer, instance: &Instance) -> Node {
    Node::new(Class::Shape, "instance", &instance.place)
        .id(&instance.id)
        .placement(&instance.to_world, &instance.motion)
        .child(group(writer, &instance.group))
}

pub(super) fn solid(writer: &mut Writer, solid: &Solid) -> Node {
    let node = Node::new(Class::Shape, solids::word(solid.operation), &solid.place)
        .id(&solid.id)
        .placement(&solid.to_world, &solid.motion);
    solid.parts.iter().fold(node, |node, part| match part {
        Part::Shape(shape) => node.child(shapes::node(shape, writer)),
        Part::Solid(part) => node.child(self::solid(writer, part)),
    })
}

fn group(writer: &mut Writer, group: &Arc<ShapeGroup>) -> Rc<Node> {
    if let Some(node) = writer.groups.get(&Arc::as_ptr(group)) {
        return node.clone();
    }
    let node = Node::new(Class::Shape, "shapegroup", &group.place).id(&group.id);
    let node = group.shapes.iter().fold(node, |node, shape| node.child(shapes::node(shape, writer)));
    let node = group.solids.iter().fold(node, |node, part| node.child(solid(writer, part)));
    let inner = |node: Node, inner: &Instance| node.child(instance(writer, inner));
    let node = Rc::new(group.instances.iter().fold(node, inner));
    writer.groups.insert(Arc::as_ptr(group), node.clone());
    node
}
