//! Rings in a graph (Tarjan 1972), without recursion.

/// Calls a function with each node behind one.
pub(super) type EachBehind<'a> = &'a dyn Fn(u32, &mut dyn FnMut(u32));

/// A node whose followers are being looked at.
struct Visit {
    node: u32,
    followers: Vec<u32>,
    next: usize,
}

const UNSEEN: u32 = u32::MAX;

/// Returns the strongly connected components of the nodes of a list, out of `count`, the last ones first: followers before those that they follow.
/// Followers that are not in the list must not exist.
pub(super) fn strong_components(nodes: &[u32], count: usize, each_behind: EachBehind<'_>) -> Vec<Vec<u32>> {
    let mut number = vec![UNSEEN; count];
    let mut lowest = vec![UNSEEN; count];
    let mut is_open = vec![false; count];
    let (mut open, mut found, mut visits) = (Vec::new(), Vec::new(), Vec::new());
    let mut counter = 0u32;
    for &root in nodes {
        if number[root as usize] != UNSEEN {
            continue;
        }
        let mut enter = Some(root);
        loop {
            if let Some(node) = enter.take() {
                (number[node as usize], lowest[node as usize]) = (counter, counter);
                counter += 1;
                open.push(node);
                is_open[node as usize] = true;
                let mut followers = Vec::new();
                each_behind(node, &mut |next| followers.push(next));
                visits.push(Visit { node, followers, next: 0 });
            }
            let Some(Visit { node, followers, next }) = visits.last_mut() else { break };
            let at = *node as usize;
            if let Some(&follower) = followers.get(*next) {
                *next += 1;
                let f = follower as usize;
                if number[f] == UNSEEN {
                    enter = Some(follower);
                } else if is_open[f] {
                    lowest[at] = lowest[at].min(number[f]);
                }
                continue;
            }
            // All followers have been seen: the node may close a component.
            if lowest[at] == number[at] {
                let first = open.iter().rposition(|&n| n as usize == at).unwrap_or(0);
                let component = open.split_off(first);
                component.iter().for_each(|&n| is_open[n as usize] = false);
                found.push(component);
            }
            let low = lowest[at];
            visits.pop();
            if let Some(above) = visits.last() {
                let above = above.node as usize;
                lowest[above] = lowest[above].min(low);
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rings_are_components_and_followers_come_first() {
        // 0 → 1 → 2 → 0 is a ring, 3 leads to it, 4 and 5 follow.
        let edges: [&[u32]; 6] = [&[1], &[2, 4], &[0], &[0], &[5], &[]];
        let each = |node: u32, visit: &mut dyn FnMut(u32)| edges[node as usize].iter().for_each(|&n| visit(n));
        let found: Vec<Vec<u32>> = strong_components(&[0, 1, 2, 3, 4, 5], 6, &each)
            .into_iter()
            .map(|mut c| {
                c.sort_unstable();
                c
            })
            .collect();
        assert_eq!(found, [vec![5], vec![4], vec![0, 1, 2], vec![3]]);
    }
}
