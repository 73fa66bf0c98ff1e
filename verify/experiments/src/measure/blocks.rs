//! The irreducible blocks of a matrix.

use nalgebra::DMatrix;
use petgraph::algo::tarjan_scc;
use petgraph::graph::{DiGraph, NodeIndex};

/// The blocks on the diagonal of a square matrix, with rows and columns in an order in which it is block triangular and its blocks are smallest: their
/// eigenvalues together are its own. A block has the unknowns that act on each other, over entries that are not zero.
pub(super) fn irreducible_blocks(a: &DMatrix<f64>) -> Vec<DMatrix<f64>> {
    let mut graph = DiGraph::<(), ()>::with_capacity(a.nrows(), 0);
    let nodes: Vec<NodeIndex> = (0..a.nrows()).map(|_| graph.add_node(())).collect();
    for (j, column) in a.column_iter().enumerate() {
        for (i, _) in column.iter().enumerate().filter(|(_, x)| **x != 0.0) {
            graph.add_edge(nodes[j], nodes[i], ());
        }
    }
    let unknowns = tarjan_scc(&graph).into_iter().map(|block| block.into_iter().map(NodeIndex::index).collect());
    unknowns
        .map(|mut block: Vec<usize>| {
            // In their own order, so that a matrix of one block is itself.
            block.sort_unstable();
            DMatrix::from_fn(block.len(), block.len(), |i, j| a[(block[i], block[j])])
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 0 and 2 act on each other, and on 1; 3 stands alone.
    #[test]
    fn what_acts_on_each_other_is_a_block_in_its_own_order() {
        let rows = [1.0, 0.0, 2.0, 0.0, 3.0, 4.0, 5.0, 0.0, 6.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 7.0];
        let mut blocks = irreducible_blocks(&DMatrix::from_row_slice(4, 4, &rows));
        blocks.sort_by(|a, b| b.len().cmp(&a.len()).then(a[(0, 0)].total_cmp(&b[(0, 0)])));
        let one = |x: f64| DMatrix::from_element(1, 1, x);
        assert_eq!(blocks, [DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 6.0, 0.0]), one(4.0), one(7.0)]);
    }

    #[test]
    fn a_ring_is_one_block_and_a_chain_has_one_for_each_unknown() {
        let ring = DMatrix::from_fn(64, 64, |i, j| if (i + 1) % 64 == j { 1.0 } else { 0.0 });
        assert_eq!(irreducible_blocks(&ring), [ring]);
        let chain = DMatrix::from_fn(64, 64, |i, j| if i + 1 == j { 1.0 } else { 0.0 });
        assert_eq!(irreducible_blocks(&chain), vec![DMatrix::zeros(1, 1); 64]);
        assert!(irreducible_blocks(&DMatrix::zeros(0, 0)).is_empty());
    }
}
